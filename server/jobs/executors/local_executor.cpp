#include "server/jobs/executors/local_executor.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <system_error>
#include <vector>

#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

void kill_and_wait(const WorkerProcess& worker) {
  constexpr int longest_ms = 5000;
  worker.signal(SIGKILL);
  pollfd waiting{worker.handle(), POLLIN, 0};
  if (::poll(&waiting, 1, longest_ms) <= 0)
    log::error("a killed worker is still running after {} ms", longest_ms);
}

bool may_supervise(const ClaimHolder& holder, const WorkerLaunch& launch) {
  return holder.claim && holder.claim->protocol == worker_protocol &&
         holder.claim->job_id == launch.job_id && holder.claim->attempt == launch.attempt;
}

}  // namespace

LocalExecutor::LocalExecutor(WarmWorkers& workers, int capacity, Precedence& precedence)
    : warm_(workers),
      capacity_(capacity),
      precedence_(precedence),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_) throw std::system_error(errno, std::generic_category(), "eventfd");
  thread_ = std::thread([this] { run(); });
}

void LocalExecutor::end_thread() {
  if (!thread_.joinable()) return;
  post([this] { stopping_ = true; });
  thread_.join();
}

void LocalExecutor::let_workers_run() {
  post([this] { leaves_workers_ = true; });
  end_thread();
}

void LocalExecutor::post(std::function<void()> order) {
  {
    const std::lock_guard lock(mutex_);
    orders_.push_back(std::move(order));
  }
  ::eventfd_write(wake_.get(), 1);
}

void LocalExecutor::start(const WorkerLaunch& launch) {
  post([this, launch] { hand_over(launch); });
}

void LocalExecutor::stop(const std::string& job_id, int attempt) {
  post([this, key = Key(job_id, attempt)] {
    const auto found = workers_.find(key);
    if (found == workers_.end()) return;

    // A stopped process would receive the signal only after it is continued.
    found->second.registration.leave();
    found->second.awaits_claim = false;
    found->second.process->signal(SIGTERM);
  });
}

void LocalExecutor::kill(const std::string& job_id, int attempt) {
  post([this, key = Key(job_id, attempt)] {
    if (const auto found = workers_.find(key); found != workers_.end())
      found->second.process->signal(SIGKILL);
  });
}

void LocalExecutor::enter_precedence(const Key& key, Supervised& worker) {
  worker.awaits_claim = false;
  const auto on_change = [this, key](const std::optional<MoreUrgentRun>& stopped_for) {
    post([=, this] { set_stopped(key, stopped_for); });
  };
  // The registration ends before the process object does.
  const auto processor_s = [process = worker.process.get()] { return process->processor_s(); };

  worker.registration = precedence_.enter({.urgency = worker.launch.urgency,
                                           .estimated_s = worker.launch.estimated_s,
                                           .on_change = on_change,
                                           .processor_s = processor_s});
}

void LocalExecutor::look_for_claims() {
  for (auto& [key, worker] : workers_)
    if (worker.awaits_claim &&
        signs_in(worker.launch.folder).claimed_ns != worker.claimed_before_ns)
      enter_precedence(key, worker);
}

void LocalExecutor::set_stopped(const Key& key, const std::optional<MoreUrgentRun>& stopped_for) {
  const auto found = workers_.find(key);
  if (found == workers_.end()) return;

  // The timers of an attempt stop before its worker does, and continue after it.
  const auto& [job_id, attempt] = key;
  if (stopped_for)
    calls_.stopped(job_id, attempt,
                   fmt::format("{}, about {:.0f} s", stopped_for->description(),
                               std::max(1.0, stopped_for->remaining_s)));
  found->second.process->set_stopped(stopped_for.has_value());
  if (!stopped_for) calls_.stopped(job_id, attempt, "");
}

Adoption LocalExecutor::adopt(const WorkerLaunch& launch, bool wanted) {
  std::optional<ClaimHolder> holder;
  try {
    holder = find_holder(launch.folder);
  } catch (const std::exception& error) {
    log::error("job {}: {}", launch.job_id, error.what());
  }

  if (!holder) return Adoption::gone;

  const auto found = std::make_shared<std::unique_ptr<WorkerProcess>>(
      std::make_unique<WorkerProcess>(holder->process, std::move(holder->handle)));
  if (wanted && may_supervise(*holder, launch)) {
    (*found)->set_stopped(false);  // the last daemon may have died while it was stopped
    post([this, found, launch] {
      const Key key(launch.job_id, launch.attempt);
      enter_precedence(key, workers_[key] = {.process = std::move(*found), .launch = launch});
    });
    return Adoption::found;
  }

  log::warn("job {}: killing a worker that cannot be adopted (process {})", launch.job_id,
            holder->process);
  kill_and_wait(**found);
  return Adoption::gone;
}

void LocalExecutor::hand_over(const WorkerLaunch& launch) {
  try {
    auto worker = warm_.take();
    const auto claimed_before_ns = signs_in(launch.folder).claimed_ns;
    worker->hand_over(launch.order);
    workers_[{launch.job_id, launch.attempt}] = {.process = std::move(worker),
                                                 .launch = launch,
                                                 .claimed_before_ns = claimed_before_ns,
                                                 .awaits_claim = true};
  } catch (const std::exception& error) {
    calls_.not_started(launch.job_id, launch.attempt, error.what());
  }
}

void LocalExecutor::wait_for_event() {
  std::vector<pollfd> waiting{{wake_.get(), POLLIN, 0}};
  int timeout_ms = -1;
  for (const auto& [key, worker] : workers_) {
    waiting.push_back({worker.process->handle(), POLLIN, 0});
    // Nothing reports a claim; without pidfd_open, in some containers, nor the end of a process.
    if (worker.process->handle() < 0 || worker.awaits_claim) timeout_ms = 20;
  }
  ::poll(waiting.data(), waiting.size(), timeout_ms);
}

void LocalExecutor::collect() {
  for (auto worker = workers_.begin(); worker != workers_.end();) {
    const auto exit = worker->second.process->exit();
    if (!exit) {
      ++worker;
      continue;
    }

    const auto [job_id, attempt] = worker->first;
    worker = workers_.erase(worker);
    calls_.ended(job_id, attempt, *exit);
  }
}

void LocalExecutor::run() {
  while (!stopping_) {
    wait_for_event();
    eventfd_t count;
    ::eventfd_read(wake_.get(), &count);

    std::deque<std::function<void()>> orders;
    {
      const std::lock_guard lock(mutex_);
      orders.swap(orders_);
    }
    for (const auto& order : orders) order();

    look_for_claims();
    collect();
  }

  // Workers that have not claimed a folder get the signal of their parent's death.
  if (leaves_workers_) {
    for (auto& [key, worker] : workers_) {
      worker.registration.leave();
      worker.process->set_stopped(false);
      worker.process->leave();
    }
  }
  workers_.clear();
}

}  // namespace dccast::jobs
