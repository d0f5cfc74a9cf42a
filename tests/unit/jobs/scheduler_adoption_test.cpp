// A daemon that was started again, and an executor whose workers may have survived the last one.
#include <fstream>

#include "tests/unit/jobs/scheduler_fixture.hpp"

namespace dccast::jobs {
namespace {

using testing::ElementsAre;

class SchedulerAdoption : public SchedulerTest {
protected:
  /// Runs a job to step 3 in a daemon and leaves a copy of its folder, as a crash leaves it.
  void crash_after_three_steps(const std::function<void(Daemon&)>& before_the_crash = {}) {
    Daemon daemon(folder_.path());
    daemon.scheduler.start();
    id_ = daemon.scheduler.submit(new_job(), {}).id();
    launch_ = daemon.executor.wait_for_launch(1);
    FakeWorker worker(launch_);
    for (const std::int64_t number : {1, 2, 3}) worker.step(number);
    if (before_the_crash) before_the_crash(daemon);
    fs::copy(folder_.path(), crashed_, fs::copy_options::recursive);
    launch_.folder = crashed_ / id_;
    daemon.executor.end(launch_, "exit code 0", 0);
  }
  /// The folder's next daemon, whose executor finds the worker.
  std::unique_ptr<Daemon> restarted(WatchdogLimits watchdog = {},
                                    WorkersOfBefore workers = WorkersOfBefore::found) {
    auto daemon = std::make_unique<Daemon>(crashed_, watchdog, v1::BEGIN_ANEW, workers);
    daemon->scheduler.start();
    return daemon;
  }
  std::vector<std::int64_t> steps_in_the_log(Daemon& daemon) {
    std::vector<std::int64_t> steps;
    EventLog::Cursor cursor;
    while (const auto event = daemon.scheduler.log(id_)->read(cursor))
      if (event->has_step()) steps.push_back(event->step().step());
    return steps;
  }

  fs::path crashed_ = folder_.path().parent_path() / "crashed";
  std::string id_;
  WorkerLaunch launch_;
};

TEST_F(SchedulerAdoption, AWorkerThatIsFoundGoesOnAndItsHistoryHasNoHole) {
  crash_after_three_steps();
  const auto daemon = restarted();
  EXPECT_THAT(daemon->executor.asked_for, ElementsAre("attempt 1"));
  EXPECT_EQ(state(*daemon, id_), v1::RUNNING);
  EXPECT_EQ(daemon->scheduler.running(), 1);

  FakeWorker worker(launch_);
  for (const std::int64_t number : {4, 5}) worker.step(number);
  worker.end(RunEnd::SUCCEEDED, [](RunEnd& end) { end.set_solver("the version before"); });
  daemon->executor.end(launch_, "an unknown exit code");
  EXPECT_TRUE(becomes(*daemon, id_, v1::SUCCEEDED));
  EXPECT_EQ(daemon->scheduler.find(id_)->attempts(), 1);
  EXPECT_THAT(steps_in_the_log(*daemon), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(daemon->executor.launches(), 0u) << "its job was started twice";
  EXPECT_EQ(daemon->store.find(id_)->solver, "the version before");
}

// Recovery takes its time, and workers end in it: the job must not be taken for one at work.
TEST_F(SchedulerAdoption, AWorkerThatEndsWhileTheOthersAreLookedForIsNotMissed) {
  crash_after_three_steps();
  const auto daemon = restarted({}, WorkersOfBefore::found_at_their_end);
  EXPECT_EQ(daemon->executor.wait_for_launch(1).attempt, 2) << "it was lost, and goes on";
  EXPECT_EQ(daemon->store.find(id_)->losses.times(), 1);
}

// Its run ended while there was no daemon: nothing is computed again.
TEST_F(SchedulerAdoption, ARunThatEndedMeanwhileIsSettledFromItsFolder) {
  crash_after_three_steps([this](Daemon&) {
    FakeWorker worker(launch_);
    worker.end(RunEnd::SUCCEEDED, [](RunEnd& end) { end.set_solver("s"); });
  });
  Daemon daemon(crashed_);
  EXPECT_EQ(state(daemon, id_), v1::SUCCEEDED);
  EXPECT_EQ(daemon.scheduler.find(id_)->last_step().step(), 3);
  EXPECT_EQ(daemon.store.find(id_)->solver, "s");
  EXPECT_EQ(daemon.store.find(id_)->losses.times(), 0);
  EXPECT_EQ(daemon.scheduler.queued(), 0);
}

TEST_F(SchedulerAdoption, ARunThatStoppedBecauseNoDaemonCameGoesOn) {
  crash_after_three_steps([this](Daemon&) { FakeWorker(launch_).end(RunEnd::STOPPED); });
  Daemon daemon(crashed_);
  EXPECT_EQ(state(daemon, id_), v1::QUEUED);
  EXPECT_EQ(daemon.store.find(id_)->losses.times(), 0);
}

TEST_F(SchedulerAdoption, AWorkerWithoutASignOfLifeIsKilledAndItsJobStartedAgain) {
  crash_after_three_steps();
  const auto daemon = restarted({.heartbeat = std::chrono::milliseconds(30)});
  EXPECT_EQ(daemon->executor.wait_for_launch(1).attempt, 2);
  EXPECT_NE(daemon->store.find(id_)->losses.first_cause().find("no sign of life"),
            std::string::npos);
}

TEST_F(SchedulerAdoption, AWorkerThatDiesIsALossLikeAnyOther) {
  crash_after_three_steps();
  const auto daemon = restarted();
  daemon->executor.end(launch_, "exit code 70", 70);
  EXPECT_EQ(daemon->executor.wait_for_launch(1).attempt, 2);
  EXPECT_EQ(daemon->store.find(id_)->losses.times(), 1);
}

TEST_F(SchedulerAdoption, AJobWhoseWorkerIsGoneGoesOnFromItsCheckpoint) {
  crash_after_three_steps();
  Daemon daemon(crashed_);
  EXPECT_EQ(state(daemon, id_), v1::QUEUED);
  daemon.scheduler.start();
  EXPECT_EQ(daemon.executor.wait_for_launch(1).attempt, 2);
  EXPECT_EQ(daemon.store.find(id_)->losses.times(), 0);
}

TEST_F(SchedulerAdoption, APauseRequestedBeforeTheRestartHolds) {
  crash_after_three_steps([this](Daemon& daemon) { daemon.scheduler.pause(id_); });
  EXPECT_EQ(read_request(crashed_ / id_)->action, RequestedAction::pause);
  const auto daemon = restarted();
  FakeWorker(launch_).end(RunEnd::STOPPED);
  daemon->executor.end(launch_, "exit code 0", 0);
  EXPECT_TRUE(becomes(*daemon, id_, v1::PAUSED));
}

TEST_F(SchedulerAdoption, ACancelRequestedBeforeTheRestartHolds) {
  crash_after_three_steps([this](Daemon& daemon) { daemon.scheduler.cancel(id_, "why"); });
  Daemon daemon(crashed_);
  EXPECT_EQ(state(daemon, id_), v1::CANCELLED);
}

TEST_F(SchedulerAdoption, WhateverWorksForAJobThatDoesNotRunIsEnded) {
  crash_after_three_steps([this](Daemon&) {
    v1::Job job;
    job.set_state(v1::PAUSED);
    FakeWorker(launch_).append(state_event({.job = job}, "paused"));
  });
  const auto daemon = restarted();
  EXPECT_THAT(daemon->executor.asked_for, ElementsAre("attempt 1 to end it"));
  EXPECT_EQ(state(*daemon, id_), v1::PAUSED);
}

}  // namespace
}  // namespace dccast::jobs
