#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <atomic>
#include <cerrno>
#include <functional>
#include <system_error>
#include <thread>

#include "server/jobs/events.hpp"
#include "server/jobs/scheduler.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {

namespace fs = std::filesystem;
using Finished = v1::WorkerMessage::Finished;

/// Starts nothing; the test says what becomes of the workers.
class ScriptedExecutor : public Executor {
public:
  explicit ScriptedExecutor(int workers) : workers_(workers) {}
  void set_calls(Calls calls) override { calls_ = std::move(calls); }
  void start(const WorkerLaunch& launch) override {
    const std::lock_guard lock(mutex_);
    if (lacks_something) throw std::system_error(EMFILE, std::generic_category(), "no pipe");
    launches_.push_back(launch);
    changed_.notify_all();
  }
  int capacity() const override { return workers_; }
  void kill(const std::string& job_id, int attempt) override {
    // Not from here: the scheduler calls with its lock held, as executors have threads of their
    // own.
    ++kills_;
    killer_ = std::jthread([this, job_id, attempt] { calls_.ended(job_id, attempt, "signal 9"); });
  }
  Adoption adopt(const std::string& handle, const WorkerLaunch& launch) override {
    asked_for.push_back(handle + " of attempt " + std::to_string(launch.attempt));
    return workers_survive ? Adoption::found : Adoption::gone;
  }
  WorkerLaunch wait_for_launch(std::size_t number) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(changed_.wait_for(lock, std::chrono::seconds(5),
                                  [&] { return launches_.size() >= number; }));
    return launches_.at(number - 1);
  }
  void end(const WorkerLaunch& launch, const std::string& how) {
    calls_.ended(launch.job_id, launch.attempt, how);
  }
  void not_started(const WorkerLaunch& launch, const std::string& why) {
    calls_.not_started(launch.job_id, launch.attempt, why);
  }
  std::atomic<bool> lacks_something = false;
  bool workers_survive = false;  ///< a restart of the daemon
  std::vector<std::string> asked_for;
  int kills() const { return kills_; }
  std::size_t launches() {
    const std::lock_guard lock(mutex_);
    return launches_.size();
  }
  void started(const WorkerLaunch& launch, const std::string& handle) {
    calls_.started(launch.job_id, launch.attempt, handle);
  }

private:
  const int workers_;
  Calls calls_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<WorkerLaunch> launches_;
  std::atomic<int> kills_ = 0;
  std::jthread killer_;
};

class RecordingChannel : public WorkerChannel {
public:
  void send(const v1::WorkerOrder& order) override { orders.push_back(order); }
  std::vector<v1::WorkerOrder> orders;
};

/// A store whose file refuses what the test says.
class FailingStore : public JobStore {
public:
  using JobStore::JobStore;
  void update(const JobRecord& record, Durability durability) override {
    refuse(refuses_updates);
    JobStore::update(record, durability);
  }
  std::optional<JobRecord> find(const std::string& id) override {
    refuse(refuses_reads);
    return JobStore::find(id);
  }
  std::optional<std::string> complete_case(const std::string& id) override {
    refuse(refuses_cases);
    return JobStore::complete_case(id);
  }
  std::atomic<bool> refuses_updates = false;
  std::atomic<bool> refuses_reads = false;
  std::atomic<bool> refuses_cases = false;

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
                  v1::OtherVersion other_version = v1::BEGIN_ANEW, bool workers_survive = false)
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
    executor.workers_survive = workers_survive;
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
    return {.request_id = request_id,
            .title = "t",
            .case_sha256 = "h",
            .submitted_case = "",
            .complete_case = ""};
  }
  std::shared_ptr<Attempt> attach(Daemon& daemon, const WorkerLaunch& launch) {
    v1::WorkerMessage::Hello hello;
    hello.set_job_id(launch.job_id);
    hello.set_token(launch.token);
    return daemon.scheduler.attach(hello, channel_);
  }
  static v1::WorkerMessage step(std::int64_t number) {
    v1::WorkerMessage message;
    message.mutable_step()->set_step(number);
    return message;
  }
  static v1::WorkerMessage finished(Finished::Outcome outcome) {
    v1::WorkerMessage message;
    message.mutable_finished()->set_outcome(outcome);
    return message;
  }
  static bool eventually(const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
  }
  static v1::JobState state(Daemon& daemon, const std::string& id) {
    return daemon.scheduler.find(id)->state();
  }

  TemporaryFolder folder_;
  std::shared_ptr<RecordingChannel> channel_ = std::make_shared<RecordingChannel>();
};

}  // namespace dccast::jobs
