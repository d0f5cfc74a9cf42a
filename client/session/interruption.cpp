#include "client/session/interruption.hpp"

#include <signal.h>
#include <unistd.h>

#include <thread>

namespace dccast::client {

void Interruption::come() {
  const std::lock_guard lock(mutex_);
  came_ = true;
  if (call_ != nullptr) call_->TryCancel();
  changed_.notify_all();
}

bool Interruption::came() const {
  const std::lock_guard lock(mutex_);
  return came_;
}

void Interruption::sleep(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  if (changed_.wait_for(lock, time, [this] { return came_; })) throw Interrupted("");
}

Interruption::Call::Call(Interruption& interruption, grpc::ClientContext& context)
    : interruption_(interruption) {
  const std::lock_guard lock(interruption_.mutex_);
  interruption_.call_ = &context;
  if (interruption_.came_) context.TryCancel();
}

Interruption::Call::~Call() {
  const std::lock_guard lock(interruption_.mutex_);
  interruption_.call_ = nullptr;
}

void interrupt_by_signals(std::shared_ptr<Interruption> interruption) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals,
                  nullptr);  // later threads inherit the mask: only this one handles the signals
  std::thread([signals, interruption = std::move(interruption)] {
    int signal = 0;
    sigwait(&signals, &signal);
    interruption->come();
    const timespec grace{1, 0};
    sigtimedwait(&signals, nullptr, &grace);
    // Computing, or waiting for a pipe that no one reads. FILE.part stays and can be continued.
    static constexpr char message[] = "\ndccast: interrupted; a job that was submitted goes on\n";
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, message, sizeof message - 1);
    ::_exit(static_cast<int>(ExitCode::interrupted));
  }).detach();
}

}  // namespace dccast::client
