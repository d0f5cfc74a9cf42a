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
  if (::poll(&waiting, 1, longest_ms) <= 0) log::error("a worker that was killed does not end");
}

bool may_lead(const ClaimHolder& holder, const WorkerLaunch& launch) {
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

    // A stopped process would see the request when it is continued only: this one is stopped no
    // more.
    found->second.place.leave();
    found->second.process->signal(SIGTERM);
  });
}

void LocalExecutor::kill(const std::string& job_id, int attempt) {
  post([this, key = Key(job_id, attempt)] {
    if (const auto found = workers_.find(key); found != workers_.end())
      found->second.process->signal(SIGKILL);
  });
}

void LocalExecutor::lead(const WorkerLaunch& launch, std::unique_ptr<WorkerProcess> process) {
  const Key key(launch.job_id, launch.attempt);
  Led& led = workers_[key] = {std::move(process)};
  led.place = precedence_.enter(launch.urgency, launch.estimated_s,
                                [this, key](const std::optional<MoreUrgentRun>& stopped_for) {
                                  post([=, this] { set_stopped(key, stopped_for); });
                                });
}

void LocalExecutor::set_stopped(const Key& key, const std::optional<MoreUrgentRun>& stopped_for) {
  const auto found = workers_.find(key);
  if (found == workers_.end()) return;

  // The timers of an attempt stop before its worker does, and go on after it.
  const auto& [job_id, attempt] = key;
  if (stopped_for)
    calls_.stopped(job_id, attempt,
                   fmt::format("{}, about {:.0f} s", stopped_for->in_words(),
                               std::max(1.0, stopped_for->left_s)));
  found->second.process->set_stopped(stopped_for.has_value());
  if (!stopped_for) calls_.stopped(job_id, attempt, "");
}

Adoption LocalExecutor::adopt(const WorkerLaunch& launch, bool wanted) {
  std::optional<ClaimHolder> holder;
  try {
    holder = holder_of(launch.folder);
  } catch (const std::exception& error) {
    log::error("job {}: {}", launch.job_id, error.what());
  }
  if (!holder) return Adoption::gone;
  const auto found = std::make_shared<std::unique_ptr<WorkerProcess>>(
      std::make_unique<WorkerProcess>(std::move(holder->handle)));
  if (wanted && may_lead(*holder, launch)) {
    (*found)->set_stopped(false);  // the last daemon may have died while it was stopped
    post([this, found, launch] { lead(launch, std::move(*found)); });
    return Adoption::found;
  }
  log::warn("job {}: a worker that cannot be led on is ended (process {})", launch.job_id,
            holder->process);
  kill_and_wait(**found);
  return Adoption::gone;
}

void LocalExecutor::hand_over(const WorkerLaunch& launch) {
  try {
    auto worker = warm_.take();
    worker->hand_over(launch.order);
    lead(launch, std::move(worker));
  } catch (const std::exception& error) {
    calls_.not_started(launch.job_id, launch.attempt, error.what());
  }
}

void LocalExecutor::wait_for_something() {
  std::vector<pollfd> waiting{{wake_.get(), POLLIN, 0}};
  int timeout_ms = -1;
  for (const auto& [key, worker] : workers_) {
    waiting.push_back({worker.process->handle(), POLLIN, 0});
    // A kernel or a container without pidfd_open: look often.
    if (worker.process->handle() < 0) timeout_ms = 20;
  }
  ::poll(waiting.data(), waiting.size(), timeout_ms);
}

void LocalExecutor::collect() {
  for (auto at = workers_.begin(); at != workers_.end();) {
    const auto exit = at->second.process->exit();
    if (!exit) {
      ++at;
      continue;
    }
    const auto [job_id, attempt] = at->first;
    at = workers_.erase(at);
    calls_.ended(job_id, attempt, *exit);
  }
}

void LocalExecutor::run() {
  while (!stopping_) {
    wait_for_something();
    eventfd_t count;
    ::eventfd_read(wake_.get(), &count);
    std::deque<std::function<void()>> orders;
    {
      const std::lock_guard lock(mutex_);
      orders.swap(orders_);
    }
    for (const auto& order : orders) order();
    collect();
  }
  // Those that have claimed no folder get the signal of their parent's death.
  if (leaves_workers_) {
    for (auto& [key, worker] : workers_) {
      worker.place.leave();
      worker.process->set_stopped(false);
      worker.process->leave();
    }
  }
  workers_.clear();
}

}  // namespace dccast::jobs
