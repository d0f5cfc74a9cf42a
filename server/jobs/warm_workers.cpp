#include "server/jobs/warm_workers.hpp"

#include <algorithm>
#include <utility>

namespace dccast::jobs {

using Why = WorkerDidNotAnswer::Why;

WarmWorkers::WarmWorkers(std::filesystem::path program, const WarmWorkerLimits& limits)
    : program_(std::move(program)),
      limits_(limits),
      starter_([this](const std::stop_token& stop) { run(stop); }) {}

v1::WorkerAnswer WarmWorkers::ask(const v1::WorkerRequest& request, const CallLimits& limits,
                                  const OnEvent& on_event) {
  auto worker = lend(lent_);
  v1::WorkerAnswer answer;
  try {
    answer = worker->ask(request, limits, on_event);
  } catch (...) {
    worker.reset();  // first: two at once may be one too many for the memory
    give_back(nullptr);
    throw;
  }
  if (worker->answers() >= limits_.answers || worker->resident_bytes() > limits_.idle_bytes)
    worker.reset();
  give_back(std::move(worker));
  if (answer.has_refused()) throw WorkerDidNotAnswer(Why::refused, answer.refused());
  return answer;
}

std::unique_ptr<WorkerProcess> WarmWorkers::take() {
  int not_counted = 0;
  return lend(not_counted);
}

std::unique_ptr<WorkerProcess> WarmWorkers::lend(int& count) {
  std::unique_lock lock(mutex_);
  const int failures = failures_;
  ++waiting_;
  changed_.notify_all();
  changed_.wait(lock, [&] {
    std::erase_if(idle_, [](const auto& worker) { return !worker->waits(); });
    return !idle_.empty() || failures_ != failures;
  });
  if (failures_ == failures) --waiting_;
  if (idle_.empty()) throw WorkerDidNotAnswer(Why::not_started, failure_);
  auto worker = std::move(idle_.back());
  idle_.pop_back();
  ++count;
  changed_.notify_all();
  return worker;
}

void WarmWorkers::give_back(std::unique_ptr<WorkerProcess> worker) {
  const std::lock_guard lock(mutex_);
  --lent_;
  if (worker && static_cast<int>(idle_.size()) + lent_ < limits_.kept)
    idle_.push_back(std::move(worker));
  changed_.notify_all();
}

bool WarmWorkers::wants_more() const {
  const int idle = static_cast<int>(idle_.size());
  return waiting_ > idle || (!fails_ && idle + lent_ < limits_.kept);
}

void WarmWorkers::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return wants_more(); })) {
    lock.unlock();
    std::unique_ptr<WorkerProcess> worker;
    std::string failure;
    try {
      worker = std::make_unique<WorkerProcess>(program_);
    } catch (const std::exception& error) {
      failure = error.what();
    }
    lock.lock();
    fails_ = worker == nullptr;
    if (worker) {
      idle_.push_back(std::move(worker));
    } else {
      failure_ = failure;
      ++failures_;
      waiting_ = 0;
    }
    changed_.notify_all();
  }
}

}  // namespace dccast::jobs
