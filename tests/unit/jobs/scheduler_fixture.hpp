#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <atomic>
#include <cerrno>
#include <functional>
#include <optional>
#include <set>
#include <system_error>
#include <thread>

#include "core/storage/file.hpp"
#include "dccast/v1/worker.pb.h"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/queue/scheduler.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {

namespace fs = std::filesystem;
using v1::RunEnd;

/// Workers of an earlier daemon: one that ends as it is found has ended before it is led on.
enum class WorkersOfBefore { gone, found, found_at_their_end };

/// Starts nothing; the test says what becomes of the workers.
class ScriptedExecutor : public Executor {
public:
  explicit ScriptedExecutor(int capacity) : workers_(capacity) {}
  void set_calls(Calls calls) override { calls_ = std::move(calls); }
  void start(const WorkerLaunch& launch) override {
    const std::lock_guard lock(mutex_);
    if (lacks_something) throw std::system_error(EMFILE, std::generic_category(), "no pipe");
    launches_.push_back(launch);
    changed_.notify_all();
  }
  int capacity() const override { return workers_; }
  void stop(const std::string& job_id, int attempt) override {
    ++stops_;
    end_later(job_id, attempt, "signal 15 (Terminated)");
  }
  void kill(const std::string& job_id, int attempt) override {
    ++kills_;
    end_later(job_id, attempt, "signal 9 (Killed)");
  }
  Adoption adopt(const WorkerLaunch& launch, bool wanted) override {
    asked_for.push_back("attempt " + std::to_string(launch.attempt) + (wanted ? "" : " to end it"));
    if (workers == WorkersOfBefore::gone || !wanted) return Adoption::gone;
    if (workers == WorkersOfBefore::found_at_their_end)
      report_end(launch.job_id, launch.attempt, {"signal 9 (Killed)"});
    return Adoption::found;
  }
  WorkerLaunch wait_for_launch(std::size_t number) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(changed_.wait_for(lock, std::chrono::seconds(5),
                                  [&] { return launches_.size() >= number; }));
    return launches_.at(number - 1);
  }
  void end(const WorkerLaunch& launch, const std::string& how, std::optional<int> code = {}) {
    report_end(launch.job_id, launch.attempt, {how, code});
  }
  /// @param why  empty: it goes on
  void stopped(const WorkerLaunch& launch, const std::string& why) {
    calls_.stopped(launch.job_id, launch.attempt, why);
  }
  void not_started(const WorkerLaunch& launch, const std::string& why) {
    calls_.not_started(launch.job_id, launch.attempt, why);
  }
  std::atomic<bool> lacks_something = false;
  WorkersOfBefore workers = WorkersOfBefore::gone;
  std::vector<std::string> asked_for;
  int kills() const { return kills_; }
  int stops() const { return stops_; }
  std::size_t launches() {
    const std::lock_guard lock(mutex_);
    return launches_.size();
  }

private:
  /// Not at once: the scheduler calls with its lock held, as executors have threads of their own.
  void end_later(const std::string& job_id, int attempt, const std::string& how) {
    const std::lock_guard lock(mutex_);
    enders_.emplace_back([this, job_id, attempt, how] { report_end(job_id, attempt, {how}); });
  }
  /// A process ends once, whatever was sent to it: no call comes after the scheduler has seen it.
  void report_end(const std::string& job_id, int attempt, const WorkerExit& exit) {
    {
      const std::lock_guard lock(mutex_);
      if (!ended_.emplace(job_id, attempt).second) return;
    }
    calls_.ended(job_id, attempt, exit);
  }

  const int workers_;
  Calls calls_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<WorkerLaunch> launches_;
  std::set<std::pair<std::string, int>> ended_;
  std::atomic<int> kills_ = 0;
  std::atomic<int> stops_ = 0;
  std::vector<std::jthread> enders_;
};

/// Actions of a worker in the folder of its job.
class FakeWorker {
public:
  explicit FakeWorker(WorkerLaunch launch)
      : launch_(std::move(launch)), log_(launch_.folder / "events.log") {
    sign();
  }
  const WorkerLaunch& launch() const { return launch_; }
  /// A sign of life.
  void sign() const { storage::write_file(launch_.folder / "worker.lock", "a claim"); }
  void step(std::int64_t number) {
    v1::JobEvent event;
    event.mutable_step()->set_step(number);
    log_.append(event);
  }
  void resume(std::int64_t step) {
    v1::JobEvent event;
    event.mutable_resumed()->set_step(step);
    log_.append(event);
  }
  void append(v1::JobEvent event) { log_.append(event); }
  void end(RunEnd::Outcome outcome, const std::function<void(RunEnd&)>& change = {}) {
    v1::JobEvent event;
    event.mutable_run_ended()->set_outcome(outcome);
    event.mutable_run_ended()->set_attempt(launch_.attempt);
    if (change) change(*event.mutable_run_ended());
    log_.append(event);
  }

private:
  WorkerLaunch launch_;
  EventLog log_;
};

/// A store whose file refuses what the test says.
class FailingStore : public JobStore {
public:
  using JobStore::JobStore;
  void put(const JobRecord& record) override {
    refuse(refuses_updates);
    if (before_update) before_update();
    JobStore::put(record);
  }
  std::optional<JobRecord> find(const std::string& id) override {
    refuse(refuses_reads);
    ++reads;
    return JobStore::find(id);
  }
  std::function<void()> before_update;  ///< set before the scheduler is started
  std::atomic<bool> refuses_updates = false;
  std::atomic<bool> refuses_reads = false;
  std::atomic<int> reads = 0;

private:
  static void refuse(bool refuses) {
    constexpr int sqlite_io_error = 10;
    if (refuses) throw StoreError("job store: disk I/O error", sqlite_io_error);
  }
};

/// No file of this process grows any more while it lives, as on a full disk.
class FullDisk {
public:
  FullDisk() {
    ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit none = before_;
    none.rlim_cur = 0;
    ::setrlimit(RLIMIT_FSIZE, &none);
  }
  FullDisk(const FullDisk&) = delete;
  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }

private:
  rlimit before_{};
};

/// Everything a daemon has, over one folder; made again it stands for a daemon started again.
struct Daemon {
  explicit Daemon(const fs::path& folder, WatchdogLimits watchdog = {},
                  v1::OtherVersion other_version = v1::BEGIN_ANEW,
                  WorkersOfBefore workers = WorkersOfBefore::gone)
      : store(folder / "jobs.sqlite"),
        logs(folder),
        executor(1),
        scheduler({.attempts = {.jobs_directory = folder,
                                .worker_restarts = 1,
                                .stop_grace = std::chrono::milliseconds(50),
                                .watchdog = watchdog,
                                .other_version = other_version,
                                .job_threads = 2},
                   .maximum_queued = 2},
                  store, logs, executor) {
    executor.workers = workers;
    scheduler.recover();
  }
  FailingStore store;
  EventLogs logs;
  ScriptedExecutor executor;
  Scheduler scheduler;
};

class SchedulerTest : public testing::Test {
protected:
  static NewJob new_job(const std::string& request_id = "") {
    NewJob made;
    v1::Job& job = made.description.job;
    job.set_request_id(request_id);
    job.set_title("t");
    job.set_case_sha256("h");
    return made;
  }
  static v1::JobState state(Daemon& daemon, const std::string& id) {
    return daemon.scheduler.find(id)->state();
  }

  static bool becomes(Daemon& daemon, const std::string& id, v1::JobState wanted) {
    return eventually([&] { return state(daemon, id) == wanted; });
  }

  TemporaryFolder folder_;
};

}  // namespace dccast::jobs
