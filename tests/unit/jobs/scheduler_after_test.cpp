// Jobs that wait for others, and what may change of a job while it waits.
#include <stdexcept>

#include "server/jobs/queue/ended_jobs.hpp"
#include "tests/unit/jobs/scheduler_fixture.hpp"

namespace dccast::jobs {
namespace {

class After : public SchedulerTest {
protected:
  /// A daemon with a longer queue than that of the fixture.
  struct LongQueue {
    explicit LongQueue(const fs::path& folder, int running_per_user = 0)
        : store(folder / "jobs.sqlite"),
          logs(folder),
          executor(2),
          scheduler({.attempts = {.jobs_directory = folder, .worker_restarts = 1},
                     .maximum_running_per_user = running_per_user},
                    store, logs, executor) {
      scheduler.recover();
    }
    FailingStore store;
    EventLogs logs;
    ScriptedExecutor executor;
    Scheduler scheduler;
  };

  static std::string submit(LongQueue& daemon, const std::vector<std::string>& after = {},
                            const std::string& owner = "anna") {
    NewJob job = new_job();
    job.description.job.mutable_after()->Assign(after.begin(), after.end());
    job.description.job.set_owner(owner);
    return daemon.scheduler.submit(job, {}).id();
  }
  static bool becomes(LongQueue& daemon, const std::string& id, v1::JobState wanted) {
    return eventually([&] { return daemon.scheduler.find(id)->state() == wanted; });
  }
};

TEST_F(After, OnlyThoseThatWaitForAJobAreLookedAtWhenItEnds) {
  constexpr int others = 60;
  LongQueue daemon(folder_.path());
  const auto blocker = submit(daemon), first = submit(daemon);
  for (const auto& id : {blocker, first}) daemon.scheduler.pause(id);
  for (int i = 0; i < others; ++i) submit(daemon, {blocker});
  const auto waits = submit(daemon, {first});
  const auto waits_for_both = submit(daemon, {first, blocker});
  const int at_start = daemon.store.reads;
  daemon.scheduler.start();

  // The first look is at all, at each job that one waits for.
  EXPECT_TRUE(eventually([&] { return daemon.store.reads - at_start >= others + 3; }));

  const int before = daemon.store.reads;
  daemon.scheduler.cancel(first, "");
  EXPECT_TRUE(becomes(daemon, waits, v1::CANCELLED));
  EXPECT_TRUE(becomes(daemon, waits_for_both, v1::CANCELLED));
  EXPECT_LT(daemon.store.reads - before, others / 2);
  // The state is there a moment before the queue has let go of the job.
  EXPECT_TRUE(eventually([&] { return daemon.scheduler.queued() == others; }));
  EXPECT_TRUE(eventually([&] { return !daemon.scheduler.is_awaited(first); }));
  EXPECT_TRUE(daemon.scheduler.is_awaited(blocker));

  daemon.scheduler.shut_down();
}

TEST_F(After, AChainIsCancelledToItsEnd) {
  LongQueue daemon(folder_.path());
  std::vector<std::string> chain{submit(daemon)};
  daemon.scheduler.pause(chain.front());
  for (int i = 0; i < 20; ++i) chain.push_back(submit(daemon, {chain.back()}));
  daemon.scheduler.start();
  daemon.scheduler.cancel(chain.front(), "");
  for (const auto& id : chain) EXPECT_TRUE(becomes(daemon, id, v1::CANCELLED));
  // The state is there a moment before the queue has let go of the job.
  EXPECT_TRUE(eventually([&] { return daemon.scheduler.queued() == 0; }));
  daemon.scheduler.shut_down();
}

TEST_F(After, AJobStartsAfterAFailureAfterAnyEndOrNever) {
  LongQueue daemon(folder_.path());
  const auto awaiting = [&](const std::string& before, v1::AwaitedEnd end) {
    NewJob job = new_job();
    job.description.job.add_after(before);
    job.description.job.set_after_end(end);
    return daemon.scheduler.submit(job, {}).id();
  };
  const auto first = submit(daemon);
  const auto on_failure = awaiting(first, v1::AWAITED_FAILURE);
  const auto on_any_end = awaiting(first, v1::AWAITED_ANY_END);
  const auto on_success = awaiting(first, v1::AWAITED_SUCCESS);
  EXPECT_EQ(daemon.scheduler.find(on_failure)->held(), "waits for " + first + " to fail");
  daemon.scheduler.cancel(first, "");
  daemon.scheduler.start();

  EXPECT_TRUE(becomes(daemon, on_any_end, v1::RUNNING));
  EXPECT_TRUE(becomes(daemon, on_failure, v1::CANCELLED)) << "a cancelled job has not failed";
  EXPECT_TRUE(becomes(daemon, on_success, v1::CANCELLED));
  daemon.scheduler.shut_down();

  EXPECT_TRUE(ends_as_awaited(v1::FAILED, v1::AWAITED_FAILURE));
  EXPECT_FALSE(ends_as_awaited(v1::SUCCEEDED, v1::AWAITED_FAILURE));
}

TEST_F(After, AJobStartsNotBeforeItsTime) {
  LongQueue daemon(folder_.path());
  const auto at = [&](std::int64_t from_now_ms) {
    NewJob job = new_job();
    *job.description.job.mutable_begin_time() = timestamp(milliseconds(now()) + from_now_ms);
    return daemon.scheduler.submit(job, {}).id();
  };
  const auto past = at(-1000), soon = at(1500), late = at(3'600'000), cancelled = at(3'600'000);
  daemon.scheduler.start();
  EXPECT_TRUE(becomes(daemon, past, v1::RUNNING));
  EXPECT_EQ(daemon.scheduler.find(soon)->state(), v1::QUEUED);
  EXPECT_TRUE(daemon.scheduler.find(soon)->held().starts_with("waits until 2"));
  EXPECT_EQ(daemon.scheduler.queued(), 3);

  EXPECT_TRUE(becomes(daemon, soon, v1::RUNNING));
  EXPECT_GE(milliseconds(daemon.scheduler.find(soon)->start_time()),
            milliseconds(daemon.scheduler.find(soon)->begin_time()));
  daemon.scheduler.cancel(cancelled, "");
  EXPECT_EQ(daemon.scheduler.queued(), 1);
  EXPECT_EQ(daemon.scheduler.find(late)->state(), v1::QUEUED);
  daemon.scheduler.shut_down();
}

TEST_F(After, APriorityThatIsChangedMovesAJobAndIsKept) {
  const auto rush = [](v1::Job& job) { job.set_priority(v1::HIGH); };
  LongQueue daemon(folder_.path());
  const auto first = submit(daemon), second = submit(daemon);
  EXPECT_EQ(daemon.scheduler.mark(second, rush).job.queue_position(), 1);
  EXPECT_EQ(daemon.scheduler.find(first)->queue_position(), 2);

  v1::Job stored;
  stored.set_priority(v1::LOW);
  read_marks(folder_.path() / second, stored);
  EXPECT_EQ(stored.priority(), v1::HIGH);
}

TEST_F(After, JobsOfOneMillisecondKeepTheirOrder) {
  LongQueue daemon(folder_.path());
  std::vector<std::string> jobs;
  for (int i = 0; i < 30; ++i) jobs.push_back(submit(daemon));
  for (int i = 0; i < 30; ++i)
    EXPECT_EQ(daemon.scheduler.find(jobs[i])->queue_position(), i + 1) << i;
}

TEST_F(After, AUserAtTheLimitLeavesWorkersToOthers) {
  LongQueue daemon(folder_.path(), 1);
  const auto first = submit(daemon), second = submit(daemon), of_ben = submit(daemon, {}, "ben");
  daemon.scheduler.start();
  EXPECT_TRUE(becomes(daemon, first, v1::RUNNING));
  EXPECT_TRUE(becomes(daemon, of_ben, v1::RUNNING));
  EXPECT_EQ(daemon.scheduler.find(second)->state(), v1::QUEUED);
  EXPECT_EQ(daemon.scheduler.find(second)->held(),
            "anna has 1 jobs running; per_user.maximum_running = 1");
  daemon.scheduler.shut_down();
}

TEST_F(After, AChangeThatTheStoreRefusesLeavesTheFolderAsItWas) {
  LongQueue daemon(folder_.path());
  const auto id = submit(daemon);
  const auto pin = [](v1::Job& job) { job.set_pinned(true); };
  EXPECT_TRUE(daemon.scheduler.mark(id, pin).job.pinned());

  const auto refuse = [](v1::Job& job) {
    job.set_pinned(false);
    throw std::invalid_argument("refused");
  };
  EXPECT_THROW(daemon.scheduler.mark(id, refuse), std::invalid_argument);
  EXPECT_TRUE(daemon.scheduler.find(id)->pinned());
  EXPECT_EQ(daemon.scheduler.mark("no such job", pin).kind, Reply::Kind::not_found);

  // The folder is the truth: what the store refuses is read there.
  daemon.store.refuses_updates = true;
  const auto unpin = [](v1::Job& job) { job.set_pinned(false); };
  EXPECT_EQ(daemon.scheduler.mark(id, unpin).kind, Reply::Kind::done);
  EXPECT_TRUE(daemon.store.find(id)->job.pinned());
  EXPECT_FALSE(daemon.scheduler.find(id)->pinned());
}

TEST_F(After, RetentionTakesTheOldestAndLeavesPinnedAndAwaitedJobs) {
  LongQueue daemon(folder_.path());
  std::vector<std::string> jobs;
  for (int i = 0; i < 4; ++i) {
    jobs.push_back(submit(daemon));
    daemon.scheduler.cancel(jobs.back(), "");
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // each ends at a time of its own
  }
  daemon.scheduler.mark(jobs[0], [](v1::Job& job) { job.set_pinned(true); });
  const auto bytes = bytes_kept(folder_.path() / jobs[3]);
  EXPECT_GT(daemon.store.find(jobs[3])->bytes, bytes / 2) << "all but the last event";

  const Retention retention({.bytes = 5 * bytes / 2, .interval = std::chrono::milliseconds(5)},
                            daemon.store, daemon.scheduler);
  EXPECT_TRUE(eventually([&] { return !daemon.scheduler.find(jobs[1]); }));

  for (const int left : {0, 2, 3}) EXPECT_TRUE(daemon.scheduler.find(jobs[left]));
}

}  // namespace
}  // namespace dccast::jobs
