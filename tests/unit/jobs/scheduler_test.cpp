#include "server/jobs/scheduler.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "proto/values/uuid.hpp"
#include "server/jobs/events.hpp"
#include "tests/unit/jobs/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

namespace fs = std::filesystem;
using Finished = v1::WorkerMessage::Finished;

/// Starts nothing; the test says what becomes of the workers.
class ScriptedExecutor : public Executor {
public:
  void set_calls(Calls calls) override { calls_ = std::move(calls); }
  void start(const WorkerLaunch& launch) override {
    const std::lock_guard lock(mutex_);
    launches_.push_back(launch);
    changed_.notify_all();
  }
  void kill(const std::string& job_id, int attempt) override {
    // Not from here: the scheduler calls with its lock held, as executors have threads of their
    // own.
    killer_ = std::jthread([this, job_id, attempt] { calls_.ended(job_id, attempt, "signal 9"); });
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

private:
  Calls calls_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<WorkerLaunch> launches_;
  std::jthread killer_;
};

class RecordingChannel : public WorkerChannel {
public:
  void send(const v1::WorkerOrder& order) override { orders.push_back(order); }
  std::vector<v1::WorkerOrder> orders;
};

/// Everything a daemon has, over one folder; made again it stands for a daemon started again.
struct Daemon {
  explicit Daemon(const fs::path& folder, int workers = 1)
      : store(folder / "jobs.sqlite"),
        logs(folder),
        scheduler({.jobs_directory = folder,
                   .workers = workers,
                   .maximum_queued = 2,
                   .worker_restarts = 1,
                   .stop_grace = std::chrono::milliseconds(50)},
                  store, logs, executor) {
    scheduler.recover();
  }
  JobStore store;
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
  std::shared_ptr<jobs::Run> attach(Daemon& daemon, const WorkerLaunch& launch) {
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
  static v1::JobState state(Daemon& daemon, const std::string& id) {
    return daemon.scheduler.find(id)->state();
  }

  TemporaryFolder folder_;
  std::shared_ptr<RecordingChannel> channel_ = std::make_shared<RecordingChannel>();
};

TEST_F(SchedulerTest, RunsAJobToItsEnd) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  const auto job = daemon.scheduler.submit(new_job(), {});
  const auto launch = daemon.executor.wait_for_launch(1);
  const auto run = attach(daemon, launch);
  ASSERT_TRUE(run);
  ASSERT_EQ(channel_->orders.size(), 1u);
  EXPECT_EQ(channel_->orders[0].start().directory(), folder_.path() / job.id());
  EXPECT_FALSE(channel_->orders[0].start().resume());
  daemon.scheduler.report(run, step(1));
  daemon.scheduler.report(run, finished(Finished::SUCCEEDED));
  EXPECT_TRUE(channel_->orders.back().has_acknowledged());
  daemon.scheduler.report(run, step(2));  // too late to count
  daemon.scheduler.detach(run);
  daemon.executor.end(launch, "exit code 0");
  EXPECT_EQ(state(daemon, job.id()), v1::SUCCEEDED);
  EXPECT_EQ(daemon.scheduler.find(job.id())->last_step().step(), 1);
  EXPECT_EQ(daemon.scheduler.log(job.id())->last_sequence(), 4);  // queued, running, step, end
  EXPECT_EQ(daemon.scheduler.running(), 0);
}

TEST_F(SchedulerTest, KnowsItsWorkersByTheirToken) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  daemon.scheduler.submit(new_job(), {});
  auto launch = daemon.executor.wait_for_launch(1);
  auto stranger = launch;
  stranger.token.back() = stranger.token.back() == '0' ? '1' : '0';
  EXPECT_FALSE(attach(daemon, stranger));
  EXPECT_TRUE(attach(daemon, launch));
  EXPECT_FALSE(attach(daemon, launch));  // a second one with the same token
}

TEST_F(SchedulerTest, AResultThatIsNotThereIsNoSuccess) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  const auto job = daemon.scheduler.submit(new_job(), {});
  const auto run = attach(daemon, daemon.executor.wait_for_launch(1));
  auto message = finished(Finished::SUCCEEDED);
  message.mutable_finished()->add_artifacts()->set_name("results.h5");
  daemon.scheduler.report(run, message);
  EXPECT_EQ(daemon.scheduler.find(job.id())->failure().kind(), v1::Failure::STORAGE);
}

TEST_F(SchedulerTest, KeepsTheFirstCauseOfALoss) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  const auto job = daemon.scheduler.submit(new_job(), {});
  daemon.executor.end(daemon.executor.wait_for_launch(1), "signal 11 (Segmentation fault)");
  daemon.executor.end(daemon.executor.wait_for_launch(2), "exit code 1");
  const auto failed = *daemon.scheduler.find(job.id());
  EXPECT_EQ(failed.state(), v1::FAILED);
  EXPECT_EQ(failed.failure().kind(), v1::Failure::WORKER_LOST);
  EXPECT_NE(failed.failure().message().find("signal 11"), std::string::npos);
  EXPECT_NE(failed.failure().message().find("twice in the step after 0"), std::string::npos);
}

TEST_F(SchedulerTest, LimitsTheQueueAndRequestIds) {
  Daemon daemon(folder_.path());  // not started: everything waits
  const auto first = daemon.scheduler.submit(new_job("a"), {});
  EXPECT_EQ(daemon.scheduler.submit(new_job("a"), {}).id(), first.id());
  auto other = new_job("a");
  other.case_sha256 = "another";
  EXPECT_THROW(daemon.scheduler.submit(other, {}), RequestIdTaken);
  auto of_a_study = new_job("a");
  of_a_study.study = values::random_uuid();
  EXPECT_THROW(daemon.scheduler.submit(of_a_study, {}), RequestIdTaken);
  EXPECT_EQ(daemon.scheduler.submit(new_job("b"), {}).queue_position(), 2);
  EXPECT_THROW(daemon.scheduler.submit(new_job("c"), {}), QueueFull);
  EXPECT_EQ(daemon.scheduler.queued(), 2);
}

TEST_F(SchedulerTest, ShuttingDownPutsARunBackIntoTheQueue) {
  std::string id;
  {
    Daemon daemon(folder_.path());
    daemon.scheduler.start();
    id = daemon.scheduler.submit(new_job(), {}).id();
    daemon.executor.wait_for_launch(1);
    daemon.scheduler.shut_down();
    EXPECT_EQ(state(daemon, id), v1::QUEUED);
    EXPECT_THROW(daemon.scheduler.submit(new_job(), {}), ShuttingDown);
  }
  Daemon again(folder_.path());
  EXPECT_EQ(state(again, id), v1::QUEUED);
  EXPECT_EQ(again.scheduler.queued(), 1);
}

// The daemon died between the terminal event and the store's commit.
TEST_F(SchedulerTest, AnEndInTheLogAloneIsTakenOver) {
  std::string id;
  {
    Daemon daemon(folder_.path());
    id = daemon.scheduler.submit(new_job(), {}).id();
    v1::Job ended;
    ended.set_state(v1::FAILED);
    ended.mutable_failure()->set_message("the cause");
    ended.add_artifacts()->set_name("results.h5");
    auto event = state_event(ended, "the cause");
    daemon.logs.open(id)->append(event);
  }
  Daemon again(folder_.path());
  const auto job = *again.scheduler.find(id);
  EXPECT_EQ(job.state(), v1::FAILED);
  EXPECT_EQ(job.failure().message(), "the cause");
  EXPECT_EQ(job.artifacts(0).name(), "results.h5");
  EXPECT_TRUE(job.has_end_time());
  EXPECT_EQ(again.scheduler.log(id)->last_sequence(), 2);  // no second end
  EXPECT_EQ(again.scheduler.queued(), 0);
}

// The file with the terminal event was damaged.
TEST_F(SchedulerTest, AnEndInTheStoreAloneIsWrittenIntoTheLog) {
  Daemon daemon(folder_.path());
  const auto id = daemon.scheduler.submit(new_job(), {}).id();
  daemon.scheduler.cancel(id, "");
  const auto path = folder_.path() / id / "events.log";
  fs::resize_file(path, fs::file_size(path) - 3);
  Daemon again(folder_.path());
  EXPECT_EQ(again.scheduler.log(id)->terminal_event()->state_change().state(), v1::CANCELLED);
}

TEST_F(SchedulerTest, FoldersNobodyWasToldOfAreRemovedAndOthersKept) {
  fs::create_directories(folder_.path() / values::random_uuid());
  fs::create_directories(folder_.path() / "mine");
  Daemon daemon(folder_.path());
  EXPECT_TRUE(fs::exists(folder_.path() / "mine"));
  std::size_t folders = 0;
  for (const auto& entry : fs::directory_iterator(folder_.path())) folders += entry.is_directory();
  EXPECT_EQ(folders, 1u);
}

TEST_F(SchedulerTest, PauseCancelAndDeleteKnowTheirStates) {
  Daemon daemon(folder_.path());
  auto& scheduler = daemon.scheduler;
  using Kind = Reply::Kind;
  EXPECT_EQ(scheduler.pause(values::random_uuid()).kind, Kind::not_found);
  EXPECT_EQ(scheduler.cancel(values::random_uuid(), "").kind, Kind::not_found);
  EXPECT_EQ(scheduler.remove(values::random_uuid()).kind, Kind::not_found);
  const auto id = scheduler.submit(new_job(), {}).id();
  EXPECT_EQ(scheduler.resume(id).kind, Kind::wrong_state);
  EXPECT_EQ(scheduler.pause(id).job.state(), v1::PAUSED);
  EXPECT_EQ(scheduler.pause(id).kind, Kind::done);
  EXPECT_EQ(scheduler.queued(), 0);
  EXPECT_EQ(scheduler.remove(id).kind, Kind::wrong_state);
  EXPECT_EQ(scheduler.resume(id).job.queue_position(), 1);
  EXPECT_EQ(scheduler.cancel(id, "").job.state(), v1::CANCELLED);
  EXPECT_EQ(scheduler.cancel(id, "").kind, Kind::done);
  EXPECT_EQ(scheduler.pause(id).kind, Kind::wrong_state);
  EXPECT_EQ(scheduler.remove(id).kind, Kind::done);
  EXPECT_FALSE(fs::exists(folder_.path() / id));
}

}  // namespace
}  // namespace dccast::jobs
