#include "server/jobs/executors/slurm_executor.hpp"

#include <fmt/core.h>
#include <sys/wait.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "core/storage/storage_error.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/processes.hpp"

namespace dccast::jobs {

namespace {

/// Interval at which a signal is repeated: it may be lost when slurmctld restarts.
constexpr std::chrono::seconds between_signals{10};

/// Starts in a row that Slurm may lose before the queue is held, and for how long it is held.
constexpr int most_losses = 3;
constexpr std::chrono::minutes hold_after_losses{10};

/// Polling interval while no job is supervised.
constexpr std::chrono::seconds idle_interval{60};

const WorkerExit left_in_order{.how = "exit code 0", .code = 0};

/// Whether Slurm has withdrawn or lost the machine of a job. Its processes may still be running.
bool shows_lost_machine(const std::string& state) {
  return state == "NODE_FAIL" || state == "PREEMPTED" || state == "BOOT_FAIL" || state == "REVOKED";
}

/// Whether Slurm holds a job because it could not start it, or because it took a running job for a
/// second start after a crash of slurmctld. The job stays held until a user releases it.
bool is_held_after_failure(const SlurmJob& job) {
  return job.state == "SPECIAL_EXIT" || job.state == "REQUEUE_HOLD" ||
         job.reason.find("launch_failed") != std::string::npos ||
         job.reason.find("launch failed") != std::string::npos;
}

WorkerExit describe(const SlurmJob& job) {
  if (job.state == "OUT_OF_MEMORY")
    return {.how = "OUT_OF_MEMORY in Slurm", .code = exit_out_of_memory};

  WorkerExit exit{.how = fmt::format("{} in Slurm", job.state)};
  if (WIFEXITED(job.exit_status) && job.state == "FAILED") exit.code = WEXITSTATUS(job.exit_status);
  if (job.exit_status != 0) exit.how += fmt::format(", {}", describe_exit(job.exit_status));
  return exit;
}

/// Runs a command whose failure is only logged, because the next poll repeats it.
template <typename Command>
void try_command(const Command& command) {
  try {
    command();
  } catch (const SlurmError& error) {
    log::warn("Slurm: {}", error.what());
  }
}

/// Notes that dccastd itself cancels an attempt in Slurm. A dccastd that is started anew would take
/// its end for that of an administrator, and the job for cancelled.
void note_withdrawal(const WorkerLaunch& launch) {
  std::ofstream(launch.folder / withdrawn_file) << launch.attempt;
}

bool was_withdrawn(const WorkerLaunch& launch) {
  std::ifstream file(launch.folder / withdrawn_file);
  std::int64_t attempt = 0;
  return file >> attempt && attempt == launch.attempt;
}

}  // namespace

SlurmExecutor::SlurmExecutor(Executor& local, SlurmOptions options)
    : local_(local), options_(std::move(options)), thread_([this] { run(); }) {}

void SlurmExecutor::set_calls(Calls calls) {
  calls_ = calls;
  local_.set_calls(std::move(calls));
}

void SlurmExecutor::end_thread() {
  if (!thread_.joinable()) return;
  post([this] { stopping_ = true; });
  thread_.join();
}

void SlurmExecutor::let_workers_run() {
  end_thread();
  local_.let_workers_run();
}

void SlurmExecutor::post(std::function<void()> order) {
  const std::lock_guard lock(mutex_);
  orders_.push_back(std::move(order));
  changed_.notify_all();
}

void SlurmExecutor::supervise(const WorkerLaunch& launch, bool submitted) {
  post([this, launch, submitted] {
    const auto now = Clock::now();
    starts_[{launch.job_id, launch.attempt}] = {
        .launch = launch, .submitted = submitted, .last_sign = now, .last_listed = now};
  });
}

void SlurmExecutor::start(const WorkerLaunch& launch) {
  if (launch.order.goes_first()) return local_.start(launch);
  supervise(launch, false);
}

void SlurmExecutor::request(const std::string& job_id, int attempt, bool Start::*flag) {
  post([this, key = Key(job_id, attempt), flag] {
    if (const auto found = starts_.find(key); found != starts_.end()) found->second.*flag = true;
  });
}

void SlurmExecutor::stop(const std::string& job_id, int attempt) {
  local_.stop(job_id, attempt);
  request(job_id, attempt, &Start::stop);
}

void SlurmExecutor::kill(const std::string& job_id, int attempt) {
  local_.kill(job_id, attempt);
  request(job_id, attempt, &Start::kill);
}

Adoption SlurmExecutor::adopt(const WorkerLaunch& launch, bool wanted) {
  const auto order = read_order(launch.folder);
  if (!order || order->attempt() != launch.attempt) return local_.adopt(launch, wanted);
  if (!wanted || shows_end_of_run(launch.folder, launch.attempt)) return Adoption::gone;
  supervise(launch, true);
  return Adoption::found;
}

void SlurmExecutor::run() {
  auto next_poll = Clock::now();
  while (!stopping_) {
    std::deque<std::function<void()>> orders;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_until(lock, next_poll, [this] { return !orders_.empty(); });
      orders.swap(orders_);
    }

    // A new start is submitted at once, without waiting for the next poll.
    const std::size_t starts_before = starts_.size();
    for (const auto& order : orders) order();
    if (stopping_) return;
    if (Clock::now() < next_poll && starts_.size() == starts_before) continue;

    try {
      poll();
    } catch (const std::exception& error) {
      log::error("Slurm: {}", error.what());
    }
    next_poll = Clock::now() + options_.interval;
  }
}

void SlurmExecutor::poll() {
  if (starts_.empty() && Clock::now() - last_poll_ < idle_interval) return;
  last_poll_ = Clock::now();

  std::optional<SlurmJobs> jobs;
  std::string fault;
  try {
    jobs = slurm_jobs();
    cancel_strays(*jobs);
  } catch (const SlurmError& error) {
    fault = error.what();
  }

  // Logged once for each change, not at every poll.
  if (fault != std::exchange(fault_, fault)) {
    if (fault.empty())
      log::info("Slurm answers again");
    else
      log::warn("Slurm gives no answer; its jobs go on and are supervised again later: {}", fault);
  }

  for (auto start = starts_.begin(); start != starts_.end();) {
    const auto end = follow(start->second, jobs ? &*jobs : nullptr);
    if (!end) {
      ++start;
      continue;
    }

    const auto [job_id, attempt] = start->first;
    start = starts_.erase(start);
    if (end->not_started)
      calls_.not_started(job_id, attempt, end->exit.how);
    else
      calls_.ended(job_id, attempt, end->exit);
  }
}

void SlurmExecutor::cancel_strays(const SlurmJobs& jobs) {
  if (adopts_) return;
  for (const auto& [job_id, job] : jobs) {
    if (job.ended() || starts_.contains({job_id, job.name.attempt}) ||
        !std::filesystem::exists(options_.jobs_directory / job_id))
      continue;

    log::info("job {}: cancelling orphaned attempt {} in Slurm", job_id, job.name.attempt);
    slurm_cancel(job.name);
  }
}

bool SlurmExecutor::is_silent(const Start& start) const {
  return Clock::now() - start.last_sign >= options_.silence;
}

bool SlurmExecutor::shows_end(const Start& start) const {
  return shows_end_of_run(start.launch.folder, start.launch.attempt);
}

void SlurmExecutor::report_waiting(Start& start, const std::string& why) {
  if (why.empty() && !start.waits) return;
  start.waits = !why.empty();
  calls_.waits(start.launch.job_id, start.launch.attempt, why);
}

std::optional<SlurmExecutor::End> SlurmExecutor::follow(Start& start, const SlurmJobs* jobs) {
  const FolderSigns signs = signs_in(start.launch.folder);
  if (std::exchange(start.signs, signs) != signs) start.last_sign = Clock::now();
  if (has_begun(start.launch.folder, start.launch.attempt)) losses_ = 0;

  // A request of a client is a file in the folder, which a worker that has not begun does not see.
  if (read_request(start.launch.folder)) start.stop = true;

  if (jobs == nullptr) {
    if (start.submitted && is_silent(start) && shows_end(start)) return End{left_in_order};
    start.last_listed = Clock::now();  // it is not known to be absent
    report_waiting(start, fmt::format("Slurm gives no answer: {}", fault_));
    return std::nullopt;
  }

  if (!start.submitted) return submit(start, *jobs);

  // Slurm may show a start twice, after it was requeued: the one that has not ended counts.
  const SlurmJob* current = nullptr;
  for (auto [job, end] = jobs->equal_range(start.launch.job_id); job != end; ++job)
    if (job->second.name.attempt == start.launch.attempt && (!current || current->ended()))
      current = &job->second;
  if (current == nullptr) return follow_absent(start);

  start.last_listed = Clock::now();
  return current->ended() ? follow_ended(start, *current) : follow_listed(start, *current);
}

std::optional<SlurmExecutor::End> SlurmExecutor::submit(Start& start, const SlurmJobs& jobs) {
  if (start.stop || start.kill)
    return End{{.how = "it was stopped before it was submitted to Slurm", .of_machine = true}};

  const auto [first, last] = jobs.equal_range(start.launch.job_id);
  const bool earlier =
      std::any_of(first, last, [](const auto& entry) { return !entry.second.ended(); });
  start.submitted = std::any_of(first, last, [&](const auto& entry) {
    return !entry.second.ended() && entry.second.name.attempt == start.launch.attempt;
  });
  if (start.submitted) return std::nullopt;
  if (earlier) {
    report_waiting(start, "an earlier start of the job is being ended in Slurm");
    return std::nullopt;
  }

  v1::SolveCase order = start.launch.order;
  order.set_directory(std::filesystem::absolute(start.launch.folder));
  order.set_daemon_patience_s(0.0);  // it does not depend on a daemon
  try {
    write_order(order);
    slurm_submit(start.name(), order.directory(), std::max(order.threads(), 1), options_);
  } catch (const SlurmError& error) {
    if (error.refused) return End{{.how = error.what()}, true};
    log::warn("job {}: it is not known yet whether Slurm accepted attempt {}: {}",
              start.launch.job_id, start.launch.attempt, error.what());
  } catch (const storage::StorageError& error) {
    return End{{.how = error.what()}, true};
  }

  start.submitted = true;
  start.last_sign = start.last_listed = Clock::now();
  report_waiting(start, "Slurm has it");
  return std::nullopt;
}

std::optional<SlurmExecutor::End> SlurmExecutor::follow_listed(Start& start, const SlurmJob& job) {
  // Slurm shows the end of a job some time after the folder does.
  if (is_silent(start) && shows_end(start)) return End{left_in_order};
  start.ended.reset();

  // A requeued job waits for two minutes; its attempt must not begin a second time.
  const bool again = job.state == "PENDING" && has_begun(start.launch.folder, start.launch.attempt);
  const bool held = again || is_held_after_failure(job);
  const bool runs = job.runs() || (held && !is_silent(start));
  report_waiting(start, runs ? "" : fmt::format("waits in Slurm: {}, {}", job.state, job.reason));

  start.of_machine |= held && !runs;
  if (start.kill || start.of_machine || (start.stop && !runs)) {
    note_withdrawal(start.launch);
    try_command([&] { slurm_cancel(job.name); });
  } else if (start.stop && Clock::now() - start.last_signal > between_signals) {
    start.last_signal = Clock::now();
    try_command([&] { slurm_terminate(job.name); });
  }
  return std::nullopt;
}

std::optional<SlurmExecutor::End> SlurmExecutor::follow_ended(Start& start, const SlurmJob& job) {
  const bool cancelled = job.state == "CANCELLED" && !start.stop && !was_withdrawn(start.launch);
  if (shows_end(start)) {
    WorkerExit exit = left_in_order;
    exit.cancelled = cancelled;
    return End{exit};
  }
  const auto now = Clock::now();
  if (!start.ended) start.ended = now;

  // A completed worker has written the end of its run, which a network file system may show late.
  if (job.state == "COMPLETED") {
    if (now - *start.ended < options_.visibility) return std::nullopt;
    return End{{.how = "exit code 0, but its event log shows no end of the run", .code = 0}};
  }

  WorkerExit exit = describe(job);
  exit.cancelled = cancelled;
  if (!start.of_machine && !shows_lost_machine(job.state) && exit.code != exit_begun_before)
    return End{exit};

  // Its processes may still write: the next attempt begins only after they have fallen silent.
  if (!is_silent(start)) return std::nullopt;
  return End{{.how = fmt::format("its machine was lost or taken away ({} in Slurm)", job.state),
              .of_machine = true}};
}

std::optional<SlurmExecutor::End> SlurmExecutor::follow_absent(Start& start) {
  if (shows_end(start)) return End{left_in_order};
  if (Clock::now() - start.last_listed < options_.unsure || !is_silent(start)) return std::nullopt;

  log::warn("job {}: Slurm has lost attempt {}, and nothing writes into its folder; ending it",
            start.launch.job_id, start.launch.attempt);
  if (has_begun(start.launch.folder, start.launch.attempt) || ++losses_ < most_losses)
    return End{{.how = "Slurm has lost it", .of_machine = true}};
  lost_at_ = Clock::now().time_since_epoch().count();
  return End{{.how = lacks()}, true};
}

std::string SlurmExecutor::lacks() const {
  const Clock::time_point lost_at{Clock::duration(lost_at_)};
  if (losses_ < most_losses || Clock::now() > lost_at + hold_after_losses) return {};
  return fmt::format(
      "Slurm took {} jobs in a row and does not show them, and no worker of them has begun; look "
      "at slurm.options in the settings of dccastd, and whether squeue shows jobs of this user",
      losses_.load());
}

}  // namespace dccast::jobs
