#include "tests/unit/jobs/scheduler_fixture.hpp"

namespace dccast::jobs {
namespace {

using testing::ElementsAre;

/// The states in which a scheduler reported the jobs of a study.
class Reported {
public:
  explicit Reported(Scheduler& scheduler) : scheduler_(scheduler) {
    scheduler.observe([this](const v1::Job& job) {
      const std::lock_guard lock(mutex_);
      if (job.study() == "a study") states_.push_back(job.state());
    });
  }
  ~Reported() { scheduler_.observe({}); }
  std::vector<v1::JobState> states() {
    const std::lock_guard lock(mutex_);
    return states_;
  }

private:
  Scheduler& scheduler_;
  std::mutex mutex_;
  std::vector<v1::JobState> states_;
};

class SchedulerObserver : public SchedulerTest {
protected:
  static NewJob job_of_study() {
    NewJob job = new_job();
    job.description.job.set_study("a study");
    return job;
  }
};

TEST_F(SchedulerObserver, IsCalledForEveryStateAndTheEndOfAJob) {
  Daemon daemon(folder_.path());
  Reported reported(daemon.scheduler);
  daemon.scheduler.start();
  const auto id = daemon.scheduler.submit(job_of_study(), {}).id();
  FakeWorker worker(daemon.executor.wait_for_launch(1));
  worker.end(RunEnd::SUCCEEDED);
  daemon.executor.end(worker.launch(), "exit code 0", 0);
  ASSERT_TRUE(eventually([&] { return reported.states().size() == 2; }));
  EXPECT_TRUE(becomes(daemon, id, v1::SUCCEEDED));
  ASSERT_EQ(daemon.scheduler.remove(id).kind, Reply::Kind::done);
  EXPECT_THAT(reported.states(), ElementsAre(v1::RUNNING, v1::SUCCEEDED, v1::SUCCEEDED));
}

// Consequences of the rows of jobs are searched for when it is called.
TEST_F(SchedulerObserver, IsCalledOnceTheStoreHasTakenTheState) {
  Daemon daemon(folder_.path());
  Reported reported(daemon.scheduler);
  const auto id = daemon.scheduler.submit(job_of_study(), {}).id();
  daemon.store.refuses_updates = true;
  daemon.scheduler.cancel(id, "not needed");
  daemon.scheduler.start();
  EXPECT_TRUE(becomes(daemon, id, v1::CANCELLED));
  EXPECT_THAT(reported.states(), ElementsAre());
  daemon.store.refuses_updates = false;
  ASSERT_TRUE(eventually([&] { return !reported.states().empty(); }));
  EXPECT_EQ(reported.states().back(), v1::CANCELLED);
}

}  // namespace
}  // namespace dccast::jobs
