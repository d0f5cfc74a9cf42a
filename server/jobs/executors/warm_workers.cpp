#include "server/jobs/executors/warm_workers.hpp"

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
  auto worker = lend({.folder = folder_of(request)});
  v1::WorkerAnswer answer;
  try {
    const auto registration = limits.enter ? limits.enter(*worker) : Precedence::Registration();
    answer = worker->ask(request, limits, on_event);
  } catch (...) {
    worker.reset();  // before its successor starts: the memory may not suffice for both
    give_back(nullptr);
    throw;
  }

  // A priority that was lowered cannot be raised again.
  const bool has_low_priority = request.solve().nice() > 0;
  if (has_low_priority || worker->answers() >= limits_.answers ||
      worker->resident_bytes() > limits_.idle_bytes)
    worker.reset();
  give_back(std::move(worker));

  if (answer.has_refused()) throw WorkerDidNotAnswer(Why::refused, answer.refused());
  return answer;
}

WarmWorkers::Idle::iterator WarmWorkers::choose_idle(const Need& need) {
  const auto warm = std::ranges::find_if(idle_, [&](const auto& worker) {
    return !need.is_job && worker->answers() > 0 && worker->folder() == need.folder;
  });
  if (warm != idle_.end()) return warm;
  return std::ranges::find_if(idle_, [](const auto& worker) { return worker->answers() == 0; });
}

void WarmWorkers::make_room() {
  if (static_cast<int>(idle_.size()) + lent_ < limits_.kept) return;
  const auto used =
      std::ranges::find_if(idle_, [](const auto& worker) { return worker->answers() > 0; });
  if (used != idle_.end()) idle_.erase(used);
}

std::unique_ptr<WorkerProcess> WarmWorkers::lend(const Need& need) {
  std::unique_lock lock(mutex_);
  const int failures = failures_;
  ++waiting_;
  std::erase_if(idle_, [](const auto& worker) { return !worker->is_idle(); });
  if (!need.is_job && choose_idle(need) == idle_.end()) make_room();
  changed_.notify_all();

  auto chosen = idle_.end();
  changed_.wait(lock, [&] {
    std::erase_if(idle_, [](const auto& worker) { return !worker->is_idle(); });
    chosen = choose_idle(need);
    return chosen != idle_.end() || failures_ != failures;
  });

  // A failed start has already reset the counter.
  if (failures_ == failures) --waiting_;

  if (chosen == idle_.end()) throw WorkerDidNotAnswer(Why::not_started, failure_);

  auto worker = std::move(*chosen);
  idle_.erase(chosen);
  if (!need.is_job) ++lent_;
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
  const auto fresh =
      std::ranges::count_if(idle_, [](const auto& worker) { return worker->answers() == 0; });
  return waiting_ > fresh || (!fails_ && idle + lent_ < limits_.kept);
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
