// A daemon that was started again, and an executor whose workers may have survived the last one.
#include <fstream>

#include "proto/values/sha256.hpp"
#include "server/jobs/worker_claim.hpp"
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
    daemon.executor.started(launch_, "node7 42");
    const auto run = run_of_the_crash_ = attach(daemon, launch_);
    for (const std::int64_t number : {1, 2, 3}) daemon.scheduler.report(run, step(number));
    if (before_the_crash) before_the_crash(daemon);
    fs::copy(folder_.path(), crashed_, fs::copy_options::recursive);
    daemon.scheduler.detach(run);
    run_of_the_crash_.reset();
    daemon.executor.end(launch_, "exit code 0");
  }
  /// The folder's next daemon, whose executor finds the worker.
  std::unique_ptr<Daemon> restarted(WatchdogLimits watchdog = {}) {
    auto daemon = std::make_unique<Daemon>(crashed_, watchdog, v1::BEGIN_ANEW, true);
    daemon->scheduler.start();
    return daemon;
  }
  /// What a worker says that has run on.
  static v1::WorkerMessage::Hello running(const WorkerLaunch& launch) {
    v1::WorkerMessage::Hello hello;
    hello.set_job_id(launch.job_id);
    hello.set_token(launch.token);
    hello.set_running(true);
    hello.set_protocol(worker_protocol);
    return hello;
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
  std::shared_ptr<Attempt> run_of_the_crash_;
};

TEST_F(SchedulerAdoption, AWorkerThatIsFoundCallsAgainAndItsHistoryHasNoHole) {
  crash_after_three_steps();
  const auto daemon = restarted();
  EXPECT_THAT(daemon->executor.asked_for, ElementsAre("node7 42 of attempt 1"));
  EXPECT_EQ(state(*daemon, id_), v1::RUNNING);
  EXPECT_EQ(daemon->scheduler.running(), 1);
  const auto run = attach(*daemon, launch_);
  ASSERT_TRUE(run);
  const auto& start = channel_->orders.back().start();
  EXPECT_EQ(start.last_reported_step(), 3);
  EXPECT_TRUE(start.resume());
  EXPECT_EQ(start.threads(), 2) << "as the settings say";
  for (const std::int64_t number : {4, 5}) daemon->scheduler.report(run, step(number));
  daemon->scheduler.report(run, finished(Finished::SUCCEEDED));
  daemon->scheduler.detach(run);
  daemon->executor.end(launch_, "exit code 0");
  const auto job = *daemon->scheduler.find(id_);
  EXPECT_EQ(job.state(), v1::SUCCEEDED);
  EXPECT_EQ(job.attempts(), 1);
  EXPECT_THAT(steps_in_the_log(*daemon), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(daemon->executor.launches(), 0u) << "its job was started twice";
}

TEST_F(SchedulerAdoption, AWorkerThatRanOnIsToldWhichOfItsReportsAreThere) {
  crash_after_three_steps();
  const auto daemon = restarted();
  auto hello = running(launch_);
  hello.set_protocol(worker_protocol + 1);
  EXPECT_FALSE(daemon->scheduler.attach(hello, channel_)) << "of another protocol";
  hello.set_protocol(worker_protocol);
  const auto run = daemon->scheduler.attach(hello, channel_);
  ASSERT_TRUE(run);
  EXPECT_EQ(channel_->orders.back().start().reports_stored(), 3);
  EXPECT_FALSE(daemon->scheduler.attach(hello, channel_)) << "a second one";
  daemon->scheduler.detach(run);
  EXPECT_FALSE(daemon->scheduler.attach(hello, channel_)) << "to one daemon it calls once";
  daemon->executor.end(launch_, "exit code 70");
}

TEST_F(SchedulerAdoption, AWorkerThatThisDaemonStartedDoesNotCallAgain) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  daemon.scheduler.submit(new_job(), {});
  const auto launch = daemon.executor.wait_for_launch(1);
  EXPECT_FALSE(daemon.scheduler.attach(running(launch), channel_));
  daemon.executor.end(launch, "exit code 70");
}

TEST_F(SchedulerAdoption, AnswersAreOfTheSolverThatTheWorkerRuns) {
  crash_after_three_steps();
  const auto daemon = restarted();
  auto hello = running(launch_);
  hello.set_solver("the version before");
  const auto run = daemon->scheduler.attach(hello, channel_);
  daemon->scheduler.report(run, finished(Finished::SUCCEEDED));
  EXPECT_EQ(daemon->store.find(id_)->solver, "the version before");
  daemon->scheduler.detach(run);
  daemon->executor.end(launch_, "exit code 0");
}

TEST_F(SchedulerAdoption, AWorkerIsNotGoneOnWithWhenDamageHidesWhatItReported) {
  crash_after_three_steps();
  const auto log = crashed_ / id_ / "events.log";
  std::fstream file(log, std::ios::in | std::ios::out | std::ios::binary);
  EventLog::Cursor third_from_the_end{.sequence = 3};
  EventLog(log).read(third_from_the_end);
  file.seekp(third_from_the_end.offset + 20);
  file << "\xff\xff";
  file.close();
  const auto daemon = restarted();
  EXPECT_TRUE(eventually([&] { return daemon->executor.kills() == 1; }));
  EXPECT_EQ(daemon->executor.wait_for_launch(1).attempt, 2);
}

TEST_F(SchedulerAdoption, TheLossOfValidityIsToldOnce) {
  v1::WorkerMessage loss;
  loss.mutable_validity_lost()->set_time_s(3.0);
  crash_after_three_steps(
      [&](Daemon& daemon) { daemon.scheduler.report(run_of_the_crash_, loss); });
  const auto daemon = restarted();
  const auto run = attach(*daemon, launch_);
  daemon->scheduler.report(run, loss);
  EXPECT_EQ(daemon->scheduler.log(id_)->last_sequence(), 6);
  EXPECT_EQ(daemon->scheduler.find(id_)->validity_loss().time_s(), 3.0);
  daemon->scheduler.report(run, finished(Finished::SUCCEEDED));
  EXPECT_EQ(daemon->scheduler.find(id_)->validity_loss().time_s(), 3.0);
  daemon->scheduler.detach(run);
  daemon->executor.end(launch_, "exit code 0");
}

TEST_F(SchedulerAdoption, TheStoreKnowsTheTokenByItsHashAlone) {
  crash_after_three_steps();
  EXPECT_EQ(JobStore(crashed_ / "jobs.sqlite").find(id_)->worker_token_sha256,
            values::sha256(launch_.token));
  const auto daemon = restarted();
  auto foreign = launch_;
  foreign.token.back() = foreign.token.back() == '0' ? '1' : '0';
  EXPECT_FALSE(attach(*daemon, foreign));
  foreign.token = values::sha256(launch_.token);
  EXPECT_FALSE(attach(*daemon, foreign)) << "who has read the store is no worker";
  EXPECT_TRUE(attach(*daemon, launch_));
}

TEST_F(SchedulerAdoption, AWorkerThatDoesNotCallAgainIsKilledAndItsJobStartedAgain) {
  crash_after_three_steps();
  const auto daemon = restarted({.hello = std::chrono::milliseconds(30)});
  EXPECT_EQ(daemon->executor.wait_for_launch(1).attempt, 2);
  EXPECT_NE(daemon->store.find(id_)->first_loss.find("0.03 s of the restart of dccastd"),
            std::string::npos);
}

TEST_F(SchedulerAdoption, AWorkerThatEndsBeforeItCallsAgainIsALossLikeAnyOther) {
  crash_after_three_steps();
  const auto daemon = restarted();
  daemon->executor.end(launch_, "exit code 70");
  EXPECT_EQ(daemon->executor.wait_for_launch(1).attempt, 2);
  EXPECT_EQ(daemon->store.find(id_)->losses, 1);
}

TEST_F(SchedulerAdoption, AJobWhoseWorkerIsGoneGoesOnFromItsCheckpoint) {
  crash_after_three_steps();
  Daemon daemon(crashed_);
  EXPECT_THAT(daemon.executor.asked_for, ElementsAre("node7 42 of attempt 1"));
  EXPECT_EQ(state(daemon, id_), v1::QUEUED);
  daemon.scheduler.start();
  const auto next = daemon.executor.wait_for_launch(1);
  EXPECT_EQ(next.attempt, 2);
  EXPECT_NE(next.token, launch_.token);
  EXPECT_FALSE(attach(daemon, launch_)) << "the token of the attempt before";
  EXPECT_TRUE(attach(daemon, next));
  EXPECT_EQ(daemon.store.find(id_)->losses, 0);
}

TEST_F(SchedulerAdoption, APauseRequestedBeforeTheRestartReachesTheWorker) {
  crash_after_three_steps([this](Daemon& daemon) { daemon.scheduler.pause(id_); });
  const auto daemon = restarted();
  channel_->orders.clear();
  const auto run = attach(*daemon, launch_);
  ASSERT_EQ(channel_->orders.size(), 2u);
  EXPECT_TRUE(channel_->orders[0].has_start());
  EXPECT_TRUE(channel_->orders[1].stop().checkpoint());
  daemon->scheduler.report(run, finished(Finished::STOPPED));
  EXPECT_EQ(state(*daemon, id_), v1::PAUSED);
  daemon->scheduler.detach(run);
  daemon->executor.end(launch_, "exit code 0");
}

TEST_F(SchedulerAdoption, TheWorkerOfAJobCancelledBeforeTheRestartIsKilled) {
  crash_after_three_steps([this](Daemon& daemon) { daemon.scheduler.cancel(id_, ""); });
  const auto daemon = restarted();
  EXPECT_EQ(state(*daemon, id_), v1::CANCELLED);
  EXPECT_FALSE(attach(*daemon, launch_));
  EXPECT_TRUE(eventually([&] { return daemon->executor.kills() == 1; }));
}

// Its token is not in the store of a version before 6: it could never call again.
TEST_F(SchedulerAdoption, AWorkerThatCannotProveItselfIsKilledBeforeItsJobStartsAgain) {
  crash_after_three_steps();
  {
    JobStore store(crashed_ / "jobs.sqlite");
    auto record = *store.find(id_);
    record.worker_token_sha256.clear();
    store.update(record, Durability::full);
  }
  const auto daemon = restarted();
  EXPECT_EQ(daemon->executor.wait_for_launch(1).attempt, 2);
  EXPECT_EQ(daemon->executor.kills(), 1);
  EXPECT_EQ(daemon->store.find(id_)->losses, 0);
}

}  // namespace
}  // namespace dccast::jobs
