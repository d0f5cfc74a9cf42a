#include "tests/unit/jobs/scheduler_fixture.hpp"

#include <fstream>
#include <future>
#include <utility>

#include "proto/values/digests.hpp"

namespace dccast::jobs {
namespace {

TEST_F(SchedulerTest, RunsAJobToItsEnd) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  const auto job = daemon.scheduler.submit(new_job(), {});
  FakeWorker worker(daemon.executor.wait_for_launch(1));
  const v1::SolveCase order = worker.launch().order;

  EXPECT_EQ(order.directory(), folder_.path() / job.id());
  EXPECT_EQ(order.job_id(), job.id());
  EXPECT_EQ(order.attempt(), 1);
  EXPECT_FALSE(order.resume());

  worker.step(1);
  EXPECT_TRUE(eventually([&] { return daemon.scheduler.find(job.id())->last_step().step() == 1; }));

  worker.end(RunEnd::SUCCEEDED);
  EXPECT_EQ(state(daemon, job.id()), v1::RUNNING) << "its process is still there";

  daemon.executor.end(worker.launch(), "exit code 0", 0);
  EXPECT_TRUE(becomes(daemon, job.id(), v1::SUCCEEDED));
  EXPECT_EQ(daemon.scheduler.find(job.id())->last_step().step(), 1);
  // queued, running, step, end of the run, end of the job
  EXPECT_TRUE(eventually([&] { return daemon.scheduler.log(job.id())->last_sequence() == 5; }));
  EXPECT_EQ(daemon.scheduler.running(), 0);
}

TEST_F(SchedulerTest, AJobThatGoesFirstWaitsForNoPlace) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  daemon.scheduler.submit(new_job(), {});
  FakeWorker running(daemon.executor.wait_for_launch(1));
  const auto waiting = daemon.scheduler.submit(new_job(), {});
  NewJob query = new_job();
  query.goes_first = true;
  const auto first = daemon.scheduler.submit(query, {});
  FakeWorker worker(daemon.executor.wait_for_launch(2));

  EXPECT_EQ(worker.launch().job_id, first.id());
  EXPECT_TRUE(worker.launch().order.goes_first());
  EXPECT_EQ(worker.launch().urgency, Urgency::quick);
  EXPECT_EQ(worker.launch().order.nice(), 0);
  EXPECT_FALSE(running.launch().order.goes_first());
  EXPECT_EQ(running.launch().urgency, Urgency::batch);
  EXPECT_EQ(running.launch().order.nice(), 19);
  EXPECT_EQ(worker.launch().order.threads(), 1);

  worker.end(RunEnd::SUCCEEDED);
  daemon.executor.end(worker.launch(), "exit code 0", 0);
  EXPECT_TRUE(becomes(daemon, first.id(), v1::SUCCEEDED));
  EXPECT_EQ(state(daemon, waiting.id()), v1::QUEUED) << "the one place is taken";
  EXPECT_EQ(daemon.executor.launches(), 2u);
}

TEST_F(SchedulerTest, ATurnIsNotMadeWhileTheThreadOfTheQueueHangs) {
  Daemon daemon(folder_.path());
  std::promise<void> begun, may_go_on;
  daemon.store.before_update = [&, first = true]() mutable {
    if (!std::exchange(first, false)) return;
    begun.set_value();
    may_go_on.get_future().wait();
  };
  daemon.scheduler.start();
  EXPECT_TRUE(daemon.scheduler.is_responsive(std::chrono::seconds(10))) << "an idle one turns";

  daemon.scheduler.submit(new_job(), {});
  begun.get_future().wait();
  EXPECT_FALSE(daemon.scheduler.is_responsive(std::chrono::milliseconds(20)));

  may_go_on.set_value();
  EXPECT_TRUE(daemon.scheduler.is_responsive(std::chrono::seconds(10)));
}

// The daemon is asked to leave while the start of a job is being written.
TEST_F(SchedulerTest, ShuttingDownEndsAWorkerThatIsBeingStarted) {
  Daemon daemon(folder_.path());
  std::promise<void> begun;
  std::promise<void> may_go_on;
  daemon.store.before_update = [&, first = true]() mutable {
    if (!std::exchange(first, false)) return;
    begun.set_value();
    may_go_on.get_future().wait();
  };
  daemon.scheduler.start();
  const auto job = daemon.scheduler.submit(new_job(), {});
  begun.get_future().wait();
  std::jthread leaving([&] { daemon.scheduler.shut_down(); });
  EXPECT_TRUE(eventually([&] {
    try {
      daemon.scheduler.submit(new_job(), {});
      return false;
    } catch (const ShuttingDown&) {
      return true;
    } catch (const refusal::LimitReached&) {
      return false;
    }
  }));

  may_go_on.set_value();
  leaving.join();
  EXPECT_EQ(daemon.scheduler.running(), 0);
  EXPECT_EQ(state(daemon, job.id()), v1::QUEUED);
  EXPECT_EQ(daemon.executor.stops(), 1);
}

// The process may have ended in any way after that, for example killed while the daemon stood
// still.
TEST_F(SchedulerTest, ARunThatHasEndedIsNoDeath) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  const auto job = daemon.scheduler.submit(new_job(), {});
  FakeWorker worker(daemon.executor.wait_for_launch(1));
  storage::write_file(folder_.path() / job.id() / "checkpoint.bin", "c");
  worker.end(RunEnd::SUCCEEDED);
  daemon.executor.end(worker.launch(), "signal 9 (Killed)");
  EXPECT_TRUE(becomes(daemon, job.id(), v1::SUCCEEDED));
  EXPECT_EQ(daemon.store.find(job.id())->losses.times(), 0);
  EXPECT_EQ(daemon.scheduler.find(job.id())->attempts(), 1);
  EXPECT_TRUE(
      eventually([&] { return !fs::exists(folder_.path() / job.id() / "checkpoint.bin"); }));
}

TEST_F(SchedulerTest, TheEndOfAnAttemptBeforeIsNotThatOfThisOne) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  const auto job = daemon.scheduler.submit(new_job(), {});
  {
    FakeWorker worker(daemon.executor.wait_for_launch(1));
    worker.end(RunEnd::STOPPED);
    daemon.executor.end(worker.launch(), "exit code 0", 0);
  }
  daemon.executor.end(daemon.executor.wait_for_launch(2), "signal 9 (Killed)");
  daemon.executor.wait_for_launch(3);
  EXPECT_EQ(daemon.store.find(job.id())->losses.times(), 1);
}

TEST_F(SchedulerTest, AResultThatIsNotThereIsNoSuccess) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  const auto job = daemon.scheduler.submit(new_job(), {});
  FakeWorker worker(daemon.executor.wait_for_launch(1));
  worker.end(RunEnd::SUCCEEDED, [](RunEnd& end) { end.add_artifacts()->set_name("results.h5"); });
  daemon.executor.end(worker.launch(), "exit code 0", 0);
  EXPECT_TRUE(becomes(daemon, job.id(), v1::FAILED));
  EXPECT_EQ(daemon.scheduler.find(job.id())->failure().kind(), v1::Finding::STORAGE);
}

TEST_F(SchedulerTest, KeepsTheFirstCauseOfALoss) {
  Daemon daemon(folder_.path());
  daemon.scheduler.start();
  const auto job = daemon.scheduler.submit(new_job(), {});
  daemon.executor.end(daemon.executor.wait_for_launch(1), "signal 11 (Segmentation fault)");
  daemon.executor.end(daemon.executor.wait_for_launch(2), "exit code 1", 1);
  EXPECT_TRUE(becomes(daemon, job.id(), v1::FAILED));
  const auto failed = *daemon.scheduler.find(job.id());
  EXPECT_EQ(failed.failure().kind(), v1::Finding::WORKER_LOST);
  EXPECT_NE(failed.failure().message().find("signal 11"), std::string::npos);
  EXPECT_NE(failed.failure().message().find("twice in the step after 0"), std::string::npos);
}

TEST_F(SchedulerTest, LimitsTheQueueAndRequestIds) {
  Daemon daemon(folder_.path());  // not started: everything waits
  const auto first = daemon.scheduler.submit(new_job("a"), {});
  EXPECT_EQ(daemon.scheduler.submit(new_job("a"), {}).id(), first.id());
  auto other = new_job("a");
  other.description.job.set_case_sha256("another");
  EXPECT_THROW(daemon.scheduler.submit(other, {}), RequestIdTaken);
  auto of_a_study = new_job("a");
  of_a_study.description.job.set_study(values::random_uuid());
  EXPECT_THROW(daemon.scheduler.submit(of_a_study, {}), RequestIdTaken);
  EXPECT_EQ(daemon.scheduler.submit(new_job("b"), {}).queue_position(), 2);
  EXPECT_THROW(daemon.scheduler.submit(new_job("c"), {}), refusal::LimitReached);
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
    auto event = state_event({.job = ended}, "the cause");
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
