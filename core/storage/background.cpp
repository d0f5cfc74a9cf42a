#include "core/storage/background.hpp"

#include <utility>

namespace dccast::storage {

namespace {

constexpr std::size_t most_tasks = 3;  // one being executed, two waiting

}  // namespace

Background::~Background() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Background::post(std::function<void()> task) {
  // The thread first: if it cannot be started, no task may be left behind that wait() waits for.
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });

  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return tasks_.size() < most_tasks; });
    rethrow_background_error();
    tasks_.push_back(std::move(task));
  }
  changed_.notify_all();
}

void Background::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return tasks_.empty(); });
  rethrow_background_error();
}

void Background::rethrow_background_error() {
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void Background::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return !tasks_.empty() || ending_; });
    if (tasks_.empty()) return;

    if (!failure_) {
      // Only this thread removes the first task; others may append meanwhile, which does not move
      // it.
      const auto& task = tasks_.front();

      lock.unlock();
      std::exception_ptr failure;
      try {
        task();
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();

      failure_ = failure;
    }

    tasks_.pop_front();
    changed_.notify_all();
  }
}

}  // namespace dccast::storage
