// What the daemon lacks fails no job, and a request that was refused has changed nothing.
#include <fstream>

#include "server/jobs/step_index.hpp"
#include "tests/unit/jobs/scheduler_fixture.hpp"

namespace dccast::jobs {
namespace {

class SchedulerFaults : public SchedulerTest {
protected:
  static std::vector<v1::StepReport> steps_of(const EventLog& log) {
    return StepIndex().page(log, {}, 1000, 1 << 20)->steps;
  }
  /// A job that runs and has reported three steps.
  void run_a_job(Daemon& daemon) {
    daemon.scheduler.start();
    id_ = daemon.scheduler.submit(new_job(), {}).id();
    launch_ = daemon.executor.wait_for_launch(1);
    attempt_ = attach(daemon, launch_);
    for (int number = 1; number <= 3; ++number) daemon.scheduler.report(attempt_, step(number));
  }
  void end_worker(Daemon& daemon, const std::string& how) {
    daemon.scheduler.detach(attempt_);
    daemon.executor.end(launch_, how);
  }
  /// The second attempt goes on from step 3 and succeeds.
  void succeed_at_last(Daemon& daemon, std::size_t launch_number = 2) {
    launch_ = daemon.executor.wait_for_launch(launch_number);
    attempt_ = attach(daemon, launch_);
    daemon.scheduler.report(attempt_, step(4));
    daemon.scheduler.report(attempt_, finished(Finished::SUCCEEDED));
    end_worker(daemon, "exit code 0");
    EXPECT_EQ(state(daemon, id_), v1::SUCCEEDED);
    EXPECT_EQ(steps_of(*daemon.scheduler.log(id_)).size(), 4u);
  }

  std::string id_;
  WorkerLaunch launch_;
  std::shared_ptr<Attempt> attempt_;
};

TEST_F(SchedulerFaults, AFullDiskHoldsTheQueueAndFailsNoJob) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  const auto waiting = daemon.scheduler.submit(new_job(), {});
  {
    const FullDisk full;
    daemon.scheduler.report(attempt_, step(4));
    EXPECT_TRUE(channel_->orders.back().has_stop());
    daemon.scheduler.report(attempt_, step(5));
    daemon.scheduler.report(attempt_, finished(Finished::STOPPED));
    end_worker(daemon, "exit code 0");
    EXPECT_EQ(state(daemon, id_), v1::QUEUED);
    EXPECT_NE(daemon.scheduler.held(), "");
    EXPECT_NE(daemon.scheduler.find(waiting.id())->held(), "");
    EXPECT_EQ(daemon.scheduler.list({}).size(), 2u);
    EXPECT_THROW(daemon.scheduler.submit(new_job(), {}), StorageHeld);
  }
  succeed_at_last(daemon);
  EXPECT_EQ(daemon.scheduler.held(), "");
  EXPECT_EQ(daemon.executor.wait_for_launch(3).job_id, waiting.id());
}

// No step is written after one that was lost: the history would have a hole.
TEST_F(SchedulerFaults, NothingIsWrittenAfterAHole) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  {
    const FullDisk full;
    daemon.scheduler.report(attempt_, step(4));
  }
  daemon.scheduler.report(attempt_, step(5));
  EXPECT_EQ(steps_of(*daemon.scheduler.log(id_)).size(), 3u);
}

TEST_F(SchedulerFaults, AWorkerThatCannotWriteIsNotToBlame) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  auto full = finished(Finished::FAILED);
  full.mutable_finished()->mutable_failure()->set_kind(v1::Failure::STORAGE);
  full.mutable_finished()->mutable_failure()->set_message("No space left on device");
  daemon.scheduler.report(attempt_, full);
  EXPECT_EQ(state(daemon, id_), v1::QUEUED);
  EXPECT_NE(daemon.scheduler.held().find("No space left"), std::string::npos);
  end_worker(daemon, "exit code 0");
  succeed_at_last(daemon);
}

TEST_F(SchedulerFaults, ACancelWhoseFirstWriteFailsCanBeAskedAgain) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  daemon.store.refuses_updates = true;
  EXPECT_THROW(daemon.scheduler.cancel(id_, "why"), StoreError);
  EXPECT_THROW(daemon.scheduler.pause(id_), StoreError);
  EXPECT_FALSE(channel_->orders.back().has_stop());
  daemon.store.refuses_updates = false;
  EXPECT_EQ(daemon.scheduler.cancel(id_, "why").kind, Reply::Kind::done);
  ASSERT_TRUE(channel_->orders.back().has_stop());
  EXPECT_FALSE(channel_->orders.back().stop().checkpoint());
  end_worker(daemon, "exit code 0");
  EXPECT_EQ(state(daemon, id_), v1::CANCELLED);
}

TEST_F(SchedulerFaults, AQueuedJobStaysInTheQueueWhenItsCancelFails) {
  Daemon daemon(folder_.path());  // not started: everything waits
  const auto id = daemon.scheduler.submit(new_job(), {}).id();
  const FullDisk full;
  EXPECT_THROW(daemon.scheduler.cancel(id, ""), std::system_error);
  EXPECT_THROW(daemon.scheduler.pause(id), std::system_error);
  EXPECT_EQ(daemon.scheduler.queued(), 1);
  EXPECT_EQ(state(daemon, id), v1::QUEUED);
}

// The event log is the truth: what it holds was acknowledged, and the store follows.
TEST_F(SchedulerFaults, AStoreThatRefusesIsWrittenLater) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  daemon.store.refuses_updates = true;
  daemon.scheduler.report(attempt_, finished(Finished::SUCCEEDED));
  EXPECT_EQ(state(daemon, id_), v1::SUCCEEDED);
  EXPECT_NE(daemon.scheduler.held(), "");
  end_worker(daemon, "exit code 0");
  EXPECT_EQ(daemon.store.find(id_)->job.state(), v1::RUNNING);
  daemon.store.refuses_updates = false;
  EXPECT_TRUE(eventually([&] { return daemon.store.find(id_)->job.state() == v1::SUCCEEDED; }));
  EXPECT_TRUE(eventually([&] { return daemon.scheduler.held().empty(); }));
}

TEST_F(SchedulerFaults, AStoreThatCannotBeReadEndsNoThread) {
  Daemon daemon(folder_.path());
  daemon.store.refuses_reads = true;
  id_ = daemon.scheduler.submit(new_job(), {}).id();
  daemon.scheduler.start();
  EXPECT_TRUE(eventually([&] { return !daemon.scheduler.held().empty(); }));
  EXPECT_EQ(daemon.scheduler.queued(), 1);
  daemon.store.refuses_reads = false;
  EXPECT_EQ(daemon.executor.wait_for_launch(1).job_id, id_);
}

// Its event log is damaged and, at the same moment, its row cannot be read.
TEST_F(SchedulerFaults, ADamagedJobBesideAnUnreadableStoreEndsNoThread) {
  Daemon daemon(folder_.path());
  id_ = daemon.scheduler.submit(new_job(), {}).id();
  const auto log = folder_.path() / id_ / "events.log";
  fs::remove(log);
  fs::create_directory(log);
  daemon.store.refuses_reads = true;
  daemon.scheduler.start();
  EXPECT_TRUE(eventually([&] { return !daemon.scheduler.held().empty(); }));
  EXPECT_EQ(daemon.scheduler.queued(), 1);
  daemon.store.refuses_reads = false;
  EXPECT_TRUE(eventually([&] { return state(daemon, id_) == v1::FAILED; }));
  EXPECT_EQ(daemon.scheduler.find(id_)->failure().kind(), v1::Failure::STORAGE);
}

TEST_F(SchedulerFaults, ACaseThatCannotBeReadNowIsReadLater) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  id_ = daemon.scheduler.submit(new_job(), {}).id();
  launch_ = daemon.executor.wait_for_launch(1);
  daemon.store.refuses_cases = true;
  EXPECT_THROW(attach(daemon, launch_), StoreError);
  daemon.executor.end(launch_, "exit code 70");  // it was sent away
  EXPECT_EQ(state(daemon, id_), v1::QUEUED);
  daemon.store.refuses_cases = false;
  launch_ = daemon.executor.wait_for_launch(2);
  EXPECT_TRUE(attach(daemon, launch_));
  EXPECT_EQ(daemon.store.find(id_)->losses, 0);
}

TEST_F(SchedulerFaults, AnExecutorThatThrowsLeavesNoPhantom) {
  Daemon daemon(folder_.path());
  daemon.executor.lacks_something = true;
  id_ = daemon.scheduler.submit(new_job(), {}).id();
  daemon.scheduler.start();
  EXPECT_TRUE(eventually([&] { return !daemon.scheduler.held().empty(); }));
  EXPECT_EQ(daemon.scheduler.running(), 0);
  EXPECT_EQ(daemon.scheduler.find(id_)->attempts(), 0);
  daemon.executor.lacks_something = false;
  EXPECT_EQ(daemon.executor.wait_for_launch(1).attempt, 1);
  EXPECT_EQ(daemon.scheduler.find(id_)->attempts(), 1);
}  // and shutting down does not hang

TEST_F(SchedulerFaults, AWorkerThatCannotBeStartedCostsItsJobNothing) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  id_ = daemon.scheduler.submit(new_job(), {}).id();
  for (std::size_t number = 1; number <= 3; ++number)
    daemon.executor.not_started(daemon.executor.wait_for_launch(number), "too many open files");
  const auto launch = daemon.executor.wait_for_launch(4);
  EXPECT_EQ(launch.attempt, 1);
  EXPECT_EQ(daemon.store.find(id_)->losses, 0);
}

TEST_F(SchedulerFaults, AWorkerThatNeverCallsIsKilled) {
  Daemon daemon(folder_.path(), {.hello = std::chrono::milliseconds(30)});
  daemon.scheduler.start();
  id_ = daemon.scheduler.submit(new_job(), {}).id();
  daemon.executor.wait_for_launch(2);
  EXPECT_TRUE(eventually([&] { return state(daemon, id_) == v1::FAILED; }));
  const auto failure = daemon.scheduler.find(id_)->failure();
  EXPECT_EQ(failure.kind(), v1::Failure::WORKER_HUNG);
  EXPECT_NE(failure.message().find("did not call within 0.03 s"), std::string::npos)
      << failure.message();
}

TEST_F(SchedulerFaults, AWorkerWithoutASignOfLifeIsKilledAndItsJobGoesOn) {
  Daemon daemon(folder_.path(), {.heartbeat = std::chrono::milliseconds(100)});
  run_a_job(daemon);
  v1::WorkerMessage alive;
  alive.mutable_heartbeat();
  for (int i = 0; i < 20; ++i) {  // three times as long as it may be silent
    std::this_thread::sleep_for(std::chrono::milliseconds(15));
    daemon.scheduler.report(attempt_, alive);
  }
  EXPECT_EQ(state(daemon, id_), v1::RUNNING);
  daemon.executor.wait_for_launch(2);
  EXPECT_EQ(daemon.store.find(id_)->losses, 1);
  EXPECT_NE(daemon.store.find(id_)->first_loss.find("no sign of life for 0.1 s"),
            std::string::npos);
}

TEST_F(SchedulerFaults, AWorkerThatMakesNoStepIsKilled) {
  Daemon daemon(folder_.path(), {.stall = std::chrono::milliseconds(60)});
  run_a_job(daemon);
  v1::WorkerMessage alive;
  alive.mutable_heartbeat();
  EXPECT_TRUE(eventually([&] {
    daemon.scheduler.report(attempt_, alive);
    return daemon.store.find(id_)->losses == 1;
  }));
  EXPECT_NE(daemon.store.find(id_)->first_loss.find("no step"), std::string::npos);
}

TEST_F(SchedulerFaults, ALossAfterAResumptionNamesTheStepItReached) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  end_worker(daemon, "signal 9 (Killed)");
  launch_ = daemon.executor.wait_for_launch(2);
  attempt_ = attach(daemon, launch_);
  v1::WorkerMessage resumed;
  resumed.mutable_resumed()->set_step(2);
  daemon.scheduler.report(attempt_, resumed);
  end_worker(daemon, "signal 9 (Killed)");
  EXPECT_EQ(daemon.store.find(id_)->lost_step, 2);
}

// It died between the resumption and its next step: what the log has is not sent a second time.
TEST_F(SchedulerFaults, AfterAResumptionTheDaemonHasTheStepsUpToIt) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  v1::WorkerMessage resumed;
  resumed.mutable_resumed()->set_step(2);
  daemon.scheduler.report(attempt_, resumed);
  end_worker(daemon, "signal 9 (Killed)");
  launch_ = daemon.executor.wait_for_launch(2);
  attempt_ = attach(daemon, launch_);
  EXPECT_EQ(channel_->orders.back().start().last_reported_step(), 2);
  end_worker(daemon, "signal 9 (Killed)");
}

TEST_F(SchedulerFaults, TheWorkerIsToldWhichStepTheDaemonHas) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  end_worker(daemon, "signal 9 (Killed)");
  attach(daemon, daemon.executor.wait_for_launch(2));
  EXPECT_TRUE(channel_->orders.back().start().resume());
  EXPECT_EQ(channel_->orders.back().start().last_reported_step(), 3);
}

TEST_F(SchedulerFaults, ACheckpointOfAnotherVersionPausesTheJobWhereThatIsAsked) {
  Daemon daemon(folder_.path(), {}, v1::PAUSE);
  run_a_job(daemon);
  const auto checkpoint = folder_.path() / id_ / "checkpoint.bin";
  std::ofstream(checkpoint) << "of yesterday";
  auto other = finished(Finished::OTHER_VERSION_FOUND);
  other.mutable_finished()->mutable_failure()->set_message("written by dccast 0.0.9");
  daemon.scheduler.report(attempt_, other);
  end_worker(daemon, "exit code 0");
  EXPECT_EQ(state(daemon, id_), v1::PAUSED);
  EXPECT_FALSE(fs::exists(checkpoint));  // so that it starts over
  EXPECT_EQ(daemon.scheduler.resume(id_).job.state(), v1::QUEUED);
}

TEST_F(SchedulerFaults, ALossOfValidityIsKept) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  v1::WorkerMessage lost;
  lost.mutable_validity_lost()->set_message("the slab slides");
  lost.mutable_validity_lost()->set_time_s(165.0);
  daemon.scheduler.report(attempt_, lost);
  daemon.scheduler.report(attempt_, finished(Finished::SUCCEEDED));
  EXPECT_EQ(daemon.store.find(id_)->job.validity_loss().time_s(), 165.0);
  end_worker(daemon, "exit code 0");
}

TEST_F(SchedulerFaults, WhatWaitingJobsMayTakeIsBounded) {
  FailingStore store(folder_.path() / "jobs.sqlite");
  EventLogs logs(folder_.path());
  ScriptedExecutor executor(1);
  SchedulerOptions options;
  options.attempts.jobs_directory = folder_.path();
  options.maximum_waiting_bytes = 100;
  Scheduler scheduler(options, store, logs, executor);
  auto large = new_job();
  large.complete_case = std::string(60, 'x');
  scheduler.submit(large, {});
  EXPECT_THROW(scheduler.submit(large, {}), QueueFull);
}

TEST_F(SchedulerFaults, NoJobIsTakenWhereTooLittleIsFree) {
  FailingStore store(folder_.path() / "jobs.sqlite");
  EventLogs logs(folder_.path());
  ScriptedExecutor executor(1);
  SchedulerOptions options;
  options.attempts.jobs_directory = folder_.path();
  options.minimum_free_bytes = std::int64_t{1} << 60;
  Scheduler scheduler(options, store, logs, executor);
  EXPECT_THROW(scheduler.submit(new_job(), {}), std::system_error);
  EXPECT_TRUE(store.ids().empty());
}

// A pause was acknowledged, the store had not taken it when the daemon died.
TEST_F(SchedulerFaults, AStateInTheLogAloneIsTakenOver) {
  {
    Daemon daemon(folder_.path());
    id_ = daemon.scheduler.submit(new_job(), {}).id();
    daemon.store.refuses_updates = true;
    EXPECT_EQ(daemon.scheduler.pause(id_).job.state(), v1::PAUSED);
  }
  Daemon again(folder_.path());
  EXPECT_EQ(state(again, id_), v1::PAUSED);
  EXPECT_EQ(again.scheduler.queued(), 0);
}

}  // namespace
}  // namespace dccast::jobs
