// What the daemon lacks fails no job, and a request that was refused has changed nothing.
#include <fstream>

#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/logs/step_index.hpp"
#include "tests/support/eventually.hpp"
#include "tests/unit/jobs/failing_read.hpp"
#include "tests/unit/jobs/failing_sync.hpp"
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
    worker_.emplace(daemon.executor.wait_for_launch(1));
    for (int number = 1; number <= 3; ++number) worker_->step(number);
  }
  void end_worker(Daemon& daemon, const std::string& how, std::optional<int> code = {}) {
    daemon.executor.end(worker_->launch(), how, code);
  }
  /// The second attempt goes on from step 3 and succeeds.
  void succeed_at_last(Daemon& daemon, std::size_t launch_number = 2) {
    worker_.emplace(daemon.executor.wait_for_launch(launch_number));
    worker_->step(4);
    worker_->end(RunEnd::SUCCEEDED);
    end_worker(daemon, "exit code 0", 0);
    EXPECT_TRUE(becomes(daemon, id_, v1::SUCCEEDED));
    EXPECT_EQ(steps_of(*daemon.scheduler.log(id_)).size(), 4u);
  }

  std::string id_;
  std::optional<FakeWorker> worker_;
};

TEST_F(SchedulerFaults, AFullDiskHoldsTheQueueAndFailsNoJob) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  const auto waiting = daemon.scheduler.submit(new_job(), {});
  {
    const FullDisk full;
    EXPECT_THROW(worker_->step(4), std::system_error);
    end_worker(daemon, "exit code 74", exit_storage);
    EXPECT_TRUE(eventually([&] { return !daemon.scheduler.held().empty(); }));
    EXPECT_EQ(state(daemon, id_), v1::RUNNING) << "nothing else is on the disk";
    EXPECT_NE(daemon.scheduler.find(waiting.id())->held(), "");
    EXPECT_EQ(daemon.scheduler.list({}).size(), 2u);
    EXPECT_THROW(daemon.scheduler.submit(new_job(), {}), StorageHeld);
  }
  succeed_at_last(daemon);

  EXPECT_EQ(daemon.store.find(id_)->losses.times(), 0);
  EXPECT_EQ(daemon.scheduler.held(), "");
  EXPECT_EQ(daemon.executor.wait_for_launch(3).job_id, waiting.id());
}

TEST_F(SchedulerFaults, ShuttingDownDoesNotWaitForAFullDisk) {
  {
    Daemon daemon(folder_.path());
    run_a_job(daemon);
    const FullDisk full;
    daemon.scheduler.shut_down();
  }
  Daemon again(folder_.path());
  EXPECT_EQ(state(again, id_), v1::QUEUED);
}

TEST_F(SchedulerFaults, AWorkerThatCannotWriteIsNotToBlame) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  worker_->end(RunEnd::FAILED, [](RunEnd& end) {
    end.mutable_failure()->set_kind(v1::Finding::STORAGE);
    end.mutable_failure()->set_message("No space left on device");
  });
  end_worker(daemon, "exit code 0", 0);
  succeed_at_last(daemon);
}

// The log that could not be synced is open all the time: a client watches it.
TEST_F(SchedulerFaults, AJobWhoseLogCouldNotBeSyncedGoesOn) {
  Daemon daemon(folder_.path());
  const auto id = daemon.scheduler.submit(new_job(), {}).id();
  const auto watched = daemon.scheduler.log(id);
  {
    const FailingSync failing;
    EXPECT_EQ(daemon.scheduler.pause(id).kind, Reply::Kind::done);
    EXPECT_TRUE(eventually([&] { return failing.has_failed(); }));
  }
  EXPECT_EQ(daemon.scheduler.resume(id).kind, Reply::Kind::done);
  daemon.scheduler.start();
  EXPECT_EQ(daemon.executor.wait_for_launch(1).job_id, id);
}

/// The queue was held for good: each look at it began with this job.
TEST_F(SchedulerFaults, AJobWhoseOwnLogCannotBeReadAtItsEndFailsAlone) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  const auto other = daemon.scheduler.submit(new_job(), {}).id();
  {
    const std::string log = id_ + "/events.log";
    const FailingRead failing(log.c_str());
    end_worker(daemon, "signal 9 (Killed)");
    EXPECT_TRUE(becomes(daemon, id_, v1::FAILED));
    EXPECT_EQ(daemon.executor.wait_for_launch(2).job_id, other);
    EXPECT_EQ(daemon.scheduler.held(), "");
  }
  EXPECT_EQ(daemon.scheduler.find(id_)->failure().kind(), v1::Finding::STORAGE);
}

TEST_F(SchedulerFaults, ACancelWhoseFirstWriteFailsCanBeRequestedAgain) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  const auto folder = folder_.path() / id_;
  {
    const FullDisk full;
    EXPECT_THROW(daemon.scheduler.cancel(id_, "why"), std::system_error);
    EXPECT_THROW(daemon.scheduler.pause(id_), std::system_error);
    EXPECT_FALSE(read_request(folder));
  }

  EXPECT_EQ(daemon.scheduler.cancel(id_, "why").kind, Reply::Kind::done);
  ASSERT_TRUE(read_request(folder));
  EXPECT_EQ(read_request(folder)->action, RequestedAction::cancel);

  end_worker(daemon, "signal 9 (Killed)");
  EXPECT_TRUE(becomes(daemon, id_, v1::CANCELLED));
  EXPECT_TRUE(eventually([&] { return !read_request(folder); }));
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
  worker_->end(RunEnd::SUCCEEDED);
  end_worker(daemon, "exit code 0", 0);
  EXPECT_TRUE(becomes(daemon, id_, v1::SUCCEEDED));
  EXPECT_TRUE(eventually([&] { return !daemon.scheduler.held().empty(); }));
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

// Its event log cannot be opened, nor begun again, and, at the same moment, its row cannot be read.
TEST_F(SchedulerFaults, ADamagedJobBesideAnUnreadableStoreEndsNoThread) {
  Daemon daemon(folder_.path());
  id_ = daemon.scheduler.submit(new_job(), {}).id();
  fs::remove_all(folder_.path() / id_);
  storage::write_file(folder_.path() / id_, "no folder");
  daemon.store.refuses_reads = true;
  daemon.scheduler.start();
  EXPECT_TRUE(eventually([&] { return !daemon.scheduler.held().empty(); }));
  EXPECT_EQ(daemon.scheduler.queued(), 1);
  daemon.store.refuses_reads = false;
  EXPECT_TRUE(eventually([&] { return state(daemon, id_) == v1::FAILED; }));
  EXPECT_EQ(daemon.scheduler.find(id_)->failure().kind(), v1::Finding::STORAGE);
}

TEST_F(SchedulerFaults, AFolderInThePlaceOfAnEventLogIsSetAside) {
  Daemon daemon(folder_.path());
  id_ = daemon.scheduler.submit(new_job(), {}).id();
  const auto log = folder_.path() / id_ / "events.log";
  fs::remove(log);
  fs::create_directory(log);
  daemon.scheduler.start();
  EXPECT_EQ(daemon.executor.wait_for_launch(1).job_id, id_);
  EXPECT_TRUE(fs::is_directory(log.string() + ".damaged"));
}

// One bad block hits header and first event, which is all that the log of a waiting job has.
TEST_F(SchedulerFaults, AWaitingJobWhoseEventLogIsNoneAnyMoreWaitsOn) {
  const auto log = [this] { return folder_.path() / id_ / "events.log"; };
  {
    Daemon daemon(folder_.path());
    id_ = daemon.scheduler.submit(new_job(), {}).id();
  }
  storage::write_file(log(), std::string(fs::file_size(log()), 'x'));

  Daemon daemon(folder_.path());
  EXPECT_EQ(state(daemon, id_), v1::QUEUED);
  EXPECT_TRUE(fs::exists(log().string() + ".damaged"));
  daemon.scheduler.start();
  EXPECT_EQ(daemon.executor.wait_for_launch(1).job_id, id_);
  EXPECT_EQ(daemon.scheduler.log(id_)->content().last_state->state(), v1::RUNNING);
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
  EXPECT_EQ(daemon.store.find(id_)->losses.times(), 0);
}

TEST_F(SchedulerFaults, AWorkerThatNeverBeginsIsKilled) {
  Daemon daemon(folder_.path(), {.hello = std::chrono::milliseconds(30)});
  daemon.scheduler.start();
  id_ = daemon.scheduler.submit(new_job(), {}).id();
  daemon.executor.wait_for_launch(2);
  EXPECT_TRUE(eventually([&] { return state(daemon, id_) == v1::FAILED; }));
  const auto failure = daemon.scheduler.find(id_)->failure();
  EXPECT_EQ(failure.kind(), v1::Finding::WORKER_HUNG);
  EXPECT_NE(failure.message().find("did not begin within 0.03 s"), std::string::npos)
      << failure.message();
}

TEST_F(SchedulerFaults, AWorkerWithoutASignOfLifeIsKilledAndItsJobGoesOn) {
  Daemon daemon(folder_.path(), {.heartbeat = std::chrono::milliseconds(200)});
  run_a_job(daemon);
  for (int i = 0; i < 20; ++i) {  // three times as long as it may be silent
    std::this_thread::sleep_for(std::chrono::milliseconds(30));  // the pace of its signs
    worker_->sign();
  }
  EXPECT_EQ(state(daemon, id_), v1::RUNNING);
  daemon.executor.wait_for_launch(2);
  EXPECT_EQ(daemon.store.find(id_)->losses.times(), 1);
  EXPECT_NE(daemon.store.find(id_)->losses.first_cause().find("no sign of life for 0.2 s"),
            std::string::npos);
}

TEST_F(SchedulerFaults, TheTimersOfAStoppedWorkerStandStill) {
  constexpr std::chrono::milliseconds limit(200);
  Daemon daemon(folder_.path(), {.heartbeat = limit, .stall = limit});
  run_a_job(daemon);
  daemon.executor.stopped(worker_->launch(), "a more urgent query runs");
  EXPECT_EQ(daemon.scheduler.find(id_)->held(), "a more urgent query runs");
  // A timer that ran would have ended by then.
  EXPECT_TRUE(stays([&] { return daemon.executor.kills() == 0; }, 3 * limit));

  daemon.executor.stopped(worker_->launch(), "");
  EXPECT_EQ(daemon.scheduler.find(id_)->held(), "");
  EXPECT_TRUE(eventually([&] { return daemon.store.find(id_)->losses.times() == 1; }))
      << "they go on from where they were";
}

TEST_F(SchedulerFaults, AWorkerThatMakesNoStepIsKilled) {
  Daemon daemon(folder_.path(), {.stall = std::chrono::milliseconds(60)});
  run_a_job(daemon);
  EXPECT_TRUE(eventually([&] {
    worker_->sign();
    return daemon.store.find(id_)->losses.times() == 1;
  }));
  EXPECT_NE(daemon.store.find(id_)->losses.first_cause().find("no step"), std::string::npos);
}

/// Each of these stands where a job has, or must have, a file of its own.
TEST_F(SchedulerFaults, AJobWhoseOwnFilesAreDamagedFailsAloneAndHoldsNoQueue) {
  Daemon daemon(folder_.path());
  const auto damaged = [&](const std::string& file, bool follows, const auto& damage) {
    NewJob job = new_job();
    if (follows) job.following.emplace();
    const std::string id = daemon.scheduler.submit(job, {}).id();
    const fs::path path = folder_.path() / id / file;
    fs::remove(path);
    damage(path);
    return id;
  };
  const auto pipe = [](const fs::path& path) { ::mkfifo(path.c_str(), 0600); };
  const std::vector<std::string> ids{
      damaged("worker.lock", false, pipe),
      damaged("readings.log", true, [](const fs::path&) {}),
  };
  daemon.scheduler.start();

  for (const std::string& id : ids) {
    EXPECT_TRUE(becomes(daemon, id, v1::FAILED));
    EXPECT_EQ(daemon.scheduler.find(id)->failure().kind(), v1::Finding::STORAGE);
  }
  EXPECT_EQ(daemon.scheduler.held(), "");
  EXPECT_EQ(daemon.executor.launches(), 0U);
}

TEST_F(SchedulerFaults, AFollowedCastingThatIsNeverFedEnds) {
  Daemon daemon(folder_.path(), {.stall = std::chrono::milliseconds(10)});
  daemon.scheduler.start();
  NewJob followed = new_job();
  followed.following.emplace();
  id_ = daemon.scheduler.submit(followed, {}).id();
  worker_.emplace(daemon.executor.wait_for_launch(1));

  EXPECT_TRUE(becomes(daemon, id_, v1::FAILED));
  const v1::Finding failure = daemon.scheduler.find(id_)->failure();
  EXPECT_EQ(failure.kind(), v1::Finding::TIME_LIMIT);
  EXPECT_NE(failure.message().find("no reading has come for 0.06 s"), std::string::npos);
  EXPECT_EQ(daemon.executor.launches(), 1U) << "it is not started again";
}

TEST_F(SchedulerFaults, ALossAfterAResumptionNamesTheStepItReached) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  end_worker(daemon, "signal 9 (Killed)");
  worker_.emplace(daemon.executor.wait_for_launch(2));
  EXPECT_TRUE(worker_->launch().order.resume());
  worker_->resume(2);
  end_worker(daemon, "signal 9 (Killed)");
  EXPECT_TRUE(eventually([&] { return daemon.store.find(id_)->losses.last_step() == 2; }));
}

TEST_F(SchedulerFaults, ACheckpointOfAnotherVersionPausesTheJobWhereThatIsSet) {
  Daemon daemon(folder_.path(), {}, v1::PAUSE);
  run_a_job(daemon);
  const auto checkpoint = folder_.path() / id_ / "checkpoint.bin";
  std::ofstream(checkpoint) << "of yesterday";
  worker_->end(RunEnd::OTHER_VERSION_FOUND,
               [](RunEnd& end) { end.mutable_failure()->set_message("written by dccast 0.0.9"); });
  end_worker(daemon, "exit code 0", 0);
  EXPECT_TRUE(becomes(daemon, id_, v1::PAUSED));
  EXPECT_FALSE(fs::exists(checkpoint));  // so that it starts over
  EXPECT_EQ(daemon.scheduler.resume(id_).job.state(), v1::QUEUED);
}

TEST_F(SchedulerFaults, ALossOfValidityIsKept) {
  Daemon daemon(folder_.path());
  run_a_job(daemon);
  v1::JobEvent lost;
  lost.mutable_validity_lost()->set_message("the slab slides");
  lost.mutable_validity_lost()->set_time_s(165.0);
  worker_->append(lost);
  worker_->end(RunEnd::SUCCEEDED);
  end_worker(daemon, "exit code 0", 0);
  EXPECT_TRUE(becomes(daemon, id_, v1::SUCCEEDED));
  EXPECT_EQ(daemon.store.find(id_)->job.validity_loss().time_s(), 165.0);
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
  large.description.complete_case = std::string(60, 'x');
  scheduler.submit(large, {});
  EXPECT_THROW(scheduler.submit(large, {}), refusal::LimitReached);
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

  // Monitors and clients are told before someone submits a job.
  scheduler.recover();
  scheduler.start();
  EXPECT_TRUE(eventually([&] { return !scheduler.held().empty(); }));
  EXPECT_NE(scheduler.held().find("limits.minimum_free"), std::string::npos);
  scheduler.shut_down();
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

TEST_F(SchedulerFaults, WhatTheStoreRefusesAtTheStartIsWrittenLater) {
  {
    Daemon daemon(folder_.path());
    id_ = daemon.scheduler.submit(new_job(), {}).id();
    daemon.store.refuses_updates = true;
    daemon.scheduler.pause(id_);
  }
  FailingStore store(folder_.path() / "jobs.sqlite");
  EventLogs logs(folder_.path());
  ScriptedExecutor executor(1);
  Scheduler scheduler({.attempts = {.jobs_directory = folder_.path()}}, store, logs, executor);
  store.refuses_updates = true;
  scheduler.recover();

  EXPECT_NE(scheduler.held(), "");
  EXPECT_EQ(scheduler.find(id_)->state(), v1::PAUSED);

  store.refuses_updates = false;
  scheduler.start();
  EXPECT_TRUE(eventually([&] { return scheduler.held().empty(); }));
  EXPECT_EQ(store.find(id_)->job.state(), v1::PAUSED);
}

}  // namespace
}  // namespace dccast::jobs
