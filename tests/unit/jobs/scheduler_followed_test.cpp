// Jobs that follow castings: they start beside the others, up to a number of their own.
#include "tests/unit/jobs/scheduler_fixture.hpp"

namespace dccast::jobs {
namespace {

using ::testing::HasSubstr;

class Followed : public SchedulerTest {
protected:
  /// A daemon with one place, that follows few castings.
  struct Few {
    explicit Few(const fs::path& folder, int running_per_user = 0)
        : store(folder / "jobs.sqlite"),
          logs(folder),
          executor(1),
          scheduler({.attempts = {.jobs_directory = folder, .worker_restarts = 1},
                     .maximum_running_per_user = running_per_user,
                     .maximum_followed = 3,
                     .maximum_followed_per_user = 2},
                    store, logs, executor) {
      scheduler.recover();
      scheduler.start();
    }
    FailingStore store;
    EventLogs logs;
    ScriptedExecutor executor;
    Scheduler scheduler;
  };

  static std::string submit(Few& daemon, const std::string& owner, bool follows) {
    NewJob job = new_job();
    job.description.job.set_owner(owner);
    if (follows) job.following.emplace();
    return daemon.scheduler.submit(job, {}).id();
  }
  static bool runs(Few& daemon, const std::string& id) {
    return daemon.scheduler.find(id)->state() == v1::RUNNING;
  }
  static std::string held(Few& daemon, const std::string& id) {
    return daemon.scheduler.find(id)->held();
  }
};

/// 120 of them once made 120 workers.
TEST_F(Followed, StartUpToTheNumberOfAUserAndOfAll) {
  Few daemon(folder_.path());
  const auto first = submit(daemon, "anna", true), second = submit(daemon, "anna", true);
  const auto third = submit(daemon, "anna", true), other = submit(daemon, "ben", true);
  const auto beyond = submit(daemon, "carl", true), job = submit(daemon, "carl", false);
  for (const auto& id : {first, second, other, job})
    EXPECT_TRUE(eventually([&] { return runs(daemon, id); })) << "a job is in nobody's way";

  EXPECT_EQ(daemon.scheduler.find(third)->state(), v1::QUEUED);
  EXPECT_EQ(held(daemon, third), "anna follows 2 castings; per_user.maximum_followed = 2");
  EXPECT_EQ(held(daemon, beyond),
            "3 castings of all users are followed; limits.maximum_followed = 3");
  EXPECT_EQ(daemon.executor.launches(), 4u);

  const auto launch = daemon.executor.wait_for_launch(1);
  EXPECT_EQ(launch.job_id, first);
  daemon.scheduler.cancel(first, "");
  daemon.executor.end(launch, "signal 15 (Terminated)");
  EXPECT_TRUE(eventually([&] { return runs(daemon, third) || runs(daemon, beyond); }));
  daemon.scheduler.shut_down();
}

TEST_F(Followed, CountAmongTheRunningJobsOfTheirUser) {
  Few daemon(folder_.path(), 1);
  const auto first = submit(daemon, "anna", true);
  EXPECT_TRUE(eventually([&] { return runs(daemon, first); }));
  const auto second = submit(daemon, "anna", true), job = submit(daemon, "anna", false);
  for (const auto& id : {second, job})
    EXPECT_EQ(held(daemon, id), "anna has 1 jobs running; per_user.maximum_running = 1");
  daemon.scheduler.shut_down();
}

TEST_F(Followed, KeepTheirPlaceAfterAPause) {
  Few daemon(folder_.path());
  const auto job = submit(daemon, "anna", false);
  EXPECT_TRUE(eventually([&] { return runs(daemon, job); }));
  const auto casting = submit(daemon, "anna", true);
  const auto launch = daemon.executor.wait_for_launch(2);
  daemon.scheduler.pause(casting);
  daemon.executor.end(launch, "signal 15 (Terminated)");
  EXPECT_TRUE(eventually([&] { return daemon.scheduler.find(casting)->state() == v1::PAUSED; }));

  daemon.scheduler.resume(casting);
  EXPECT_TRUE(eventually([&] { return runs(daemon, casting); })) << "the only place is taken";
  daemon.scheduler.shut_down();
}

TEST_F(Followed, EndWhenTheirOwnerMayRunNothingAnyMore) {
  Daemon daemon(folder_.path());
  daemon.scheduler.refuse_owners([](const v1::Job& job) {
    return job.owner() == "anna" ? std::string("user anna is disabled") : std::string();
  });
  daemon.scheduler.start();
  NewJob casting = new_job();
  casting.following.emplace();
  casting.description.job.set_owner("anna");
  const auto ends = daemon.scheduler.submit(casting, {}).id();
  casting.description.job.set_owner("ben");
  const auto stays = daemon.scheduler.submit(casting, {}).id();

  EXPECT_TRUE(becomes(daemon, ends, v1::CANCELLED));
  EXPECT_EQ(daemon.scheduler.find(stays)->state(), v1::RUNNING);
  const auto end = daemon.scheduler.log(ends)->terminal_event();
  ASSERT_TRUE(end);
  EXPECT_THAT(end->state_change().cause(), HasSubstr("user anna is disabled"));
  daemon.scheduler.shut_down();
}

}  // namespace
}  // namespace dccast::jobs
