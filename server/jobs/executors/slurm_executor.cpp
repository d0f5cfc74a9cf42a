#include "server/jobs/executors/slurm_executor.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <utility>

#include "core/storage/storage_error.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/processes.hpp"

namespace dccast::jobs {

namespace {

/// A signal may get lost when slurmctld restarts.
constexpr std::chrono::seconds between_signals{10};

/// Between two questions while nothing is led.
constexpr std::chrono::seconds idle_interval{60};

const WorkerExit left_in_order{.how = "exit code 0", .code = 0};

/// Slurm takes the machine of such a job away, or has lost sight of it; its processes may run on.
bool is_of_machine(const std::string& state) {
  return state == "NODE_FAIL" || state == "PREEMPTED" || state == "BOOT_FAIL" || state == "REVOKED";
}

/// Slurm could not start a worker, or took a running one for a second start of itself, after a
/// crash of slurmctld. It stays so until someone releases it.
bool is_held_after_failure(const SlurmJob& job) {
  return job.state == "SPECIAL_EXIT" || job.state == "REQUEUE_HOLD" ||
         job.reason.find("launch_failed") != std::string::npos ||
         job.reason.find("launch failed") != std::string::npos;
}

WorkerExit exit_of(const SlurmJob& job) {
  if (job.state == "OUT_OF_MEMORY")
    return {.how = "OUT_OF_MEMORY in Slurm", .code = exit_out_of_memory};
  WorkerExit exit{.how = job.state + " in Slurm"};
  if (WIFEXITED(job.exit_status) && job.state == "FAILED") exit.code = WEXITSTATUS(job.exit_status);
  if (job.exit_status != 0) exit.how += ", " + describe_exit(job.exit_status);
  return exit;
}

/// A signal or an end that is wanted; what does not reach Slurm is tried again.
template <typename Command>
void try_command(const Command& command) {
  try {
    command();
  } catch (const SlurmError& error) {
    log::warn("Slurm: {}", error.what());
  }
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

void SlurmExecutor::lead(const WorkerLaunch& launch, bool submitted) {
  post([this, launch, submitted] {
    const auto now = Clock::now();
    starts_[{launch.job_id, launch.attempt}] = {
        .launch = launch, .submitted = submitted, .last_sign = now, .last_listed = now};
  });
}

void SlurmExecutor::start(const WorkerLaunch& launch) {
  if (launch.order.goes_first()) return local_.start(launch);
  lead(launch, false);
}

void SlurmExecutor::want(const std::string& job_id, int attempt, bool Start::*what) {
  post([this, key = Key(job_id, attempt), what] {
    if (const auto found = starts_.find(key); found != starts_.end()) found->second.*what = true;
  });
}

void SlurmExecutor::stop(const std::string& job_id, int attempt) {
  local_.stop(job_id, attempt);
  want(job_id, attempt, &Start::stop);
}

void SlurmExecutor::kill(const std::string& job_id, int attempt) {
  local_.kill(job_id, attempt);
  want(job_id, attempt, &Start::kill);
}

Adoption SlurmExecutor::adopt(const WorkerLaunch& launch, bool wanted) {
  const auto order = read_order(launch.folder);
  if (!order || order->attempt() != launch.attempt) return local_.adopt(launch, wanted);
  if (!wanted || shows_end_of_run(launch.folder, launch.attempt)) return Adoption::gone;
  lead(launch, true);
  return Adoption::found;
}

void SlurmExecutor::run() {
  auto next_look = Clock::now();
  while (!stopping_) {
    std::deque<std::function<void()>> orders;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_until(lock, next_look, [this] { return !orders_.empty(); });
      orders.swap(orders_);
    }
    const std::size_t before = starts_.size();
    for (const auto& order : orders) order();
    if (stopping_ || (Clock::now() < next_look && starts_.size() == before)) continue;
    try {
      look();
    } catch (const std::exception& error) {
      log::error("Slurm: {}", error.what());
    }
    next_look = Clock::now() + options_.interval;
  }
}

void SlurmExecutor::look() {
  if (starts_.empty() && Clock::now() - last_look_ < idle_interval) return;
  last_look_ = Clock::now();
  std::optional<SlurmJobs> jobs;
  std::string fault;
  try {
    jobs = slurm_jobs();
    cancel_strays(*jobs);
  } catch (const SlurmError& error) {
    fault = error.what();
  }
  if (fault != std::exchange(fault_, fault)) {
    if (fault.empty())
      log::info("Slurm answers again");
    else
      log::warn("Slurm gives no answer, its jobs go on: {}", fault);
  }
  for (auto at = starts_.begin(); at != starts_.end();) {
    const auto end = follow(at->second, jobs ? &*jobs : nullptr);
    if (!end) {
      ++at;
      continue;
    }
    const auto [job_id, attempt] = at->first;
    at = starts_.erase(at);
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
    log::info("job {}: its attempt {} is not led any more and is ended in Slurm", job_id,
              job.name.attempt);
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
  // What a client wants lies in the folder; a worker that is not there yet does not see it.
  if (read_request(start.launch.folder)) start.stop = true;
  if (jobs == nullptr) {
    if (start.submitted && is_silent(start) && shows_end(start)) return End{left_in_order};
    start.last_listed = Clock::now();  // it is not known to be absent
    report_waiting(start, "Slurm gives no answer: " + fault_);
    return std::nullopt;
  }
  if (!start.submitted) return submit(start, *jobs);
  const SlurmJob* newest = nullptr;
  for (auto [job, end] = jobs->equal_range(start.launch.job_id); job != end; ++job)
    if (job->second.name.attempt == start.launch.attempt && (!newest || newest->ended()))
      newest = &job->second;
  if (newest == nullptr) return follow_absent(start);
  start.last_listed = Clock::now();
  return newest->ended() ? follow_ended(start, *newest) : follow_listed(start, *newest);
}

std::optional<SlurmExecutor::End> SlurmExecutor::submit(Start& start, const SlurmJobs& jobs) {
  if (start.stop || start.kill)
    return End{{.how = "it was not submitted to Slurm any more", .of_machine = true}};
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
  order.set_daemon_patience_s(0.0);  // it needs none
  try {
    write_order(order);
    slurm_submit(start.name(), order.directory(), std::max(order.threads(), 1), options_);
  } catch (const SlurmError& error) {
    if (error.refused) return End{{.how = error.what()}, true};
    log::warn("job {}: whether Slurm has it is not known yet: {}", start.launch.job_id,
              error.what());
  } catch (const storage::StorageError& error) {
    return End{{.how = error.what()}, true};
  }
  start.submitted = true;
  start.last_sign = start.last_listed = Clock::now();
  report_waiting(start, "Slurm has it");
  return std::nullopt;
}

std::optional<SlurmExecutor::End> SlurmExecutor::follow_listed(Start& start, const SlurmJob& job) {
  if (is_silent(start) && shows_end(start)) return End{left_in_order};  // Slurm sees it later
  start.ended.reset();
  // Slurm would start it again, after two minutes.
  const bool again = job.state == "PENDING" && has_begun(start.launch.folder, start.launch.attempt);
  const bool held = again || is_held_after_failure(job);
  const bool runs = job.runs() || (held && !is_silent(start));
  report_waiting(start, runs ? "" : "waits in Slurm: " + job.state + ", " + job.reason);
  start.of_machine |= held && !runs;
  if (start.kill || start.of_machine || (start.stop && !runs)) {
    try_command([&] { slurm_cancel(job.name); });
  } else if (start.stop && Clock::now() - start.last_signal > between_signals) {
    start.last_signal = Clock::now();
    try_command([&] { slurm_terminate(job.name); });
  }
  return std::nullopt;
}

std::optional<SlurmExecutor::End> SlurmExecutor::follow_ended(Start& start, const SlurmJob& job) {
  if (shows_end(start)) return End{left_in_order};
  const auto now = Clock::now();
  if (!start.ended) start.ended = now;
  if (job.state == "COMPLETED") {  // so there is an end, which a network file system shows late
    if (now - *start.ended < options_.visibility) return std::nullopt;
    return End{{.how = "exit code 0, and no end of its run can be seen", .code = 0}};
  }
  const WorkerExit exit = exit_of(job);
  if (!start.of_machine && !is_of_machine(job.state) && exit.code != exit_begun_before)
    return End{exit};
  if (!is_silent(start)) return std::nullopt;
  return End{{.how = "its machine was lost or taken away (" + job.state + " in Slurm)",
              .of_machine = true}};
}

std::optional<SlurmExecutor::End> SlurmExecutor::follow_absent(Start& start) {
  if (shows_end(start)) return End{left_in_order};
  if (Clock::now() - start.last_listed < options_.unsure || !is_silent(start)) return std::nullopt;
  log::warn("job {}: Slurm does not know its attempt {} and nothing writes into its folder",
            start.launch.job_id, start.launch.attempt);
  return End{{.how = "Slurm has lost it", .of_machine = true}};
}

}  // namespace dccast::jobs
