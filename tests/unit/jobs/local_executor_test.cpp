#include "server/jobs/local_executor.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <condition_variable>
#include <mutex>
#include <vector>

#include "server/jobs/process.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/jobs/claiming_process.hpp"

namespace dccast::jobs {
namespace {

std::string handle_of(pid_t process) {
  return std::to_string(process) + " " + std::to_string(identify(process)->start_ticks);
}

/// What the executor says of the ends of workers.
struct Ends {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::string> ended;

  Executor::Calls calls() {
    return {.started = [](auto&&...) {},
            .not_started = [](auto&&...) {},
            .ended =
                [this](const std::string& job_id, int attempt, const std::string& how) {
                  const std::lock_guard lock(mutex);
                  ended.push_back(job_id + " " + std::to_string(attempt) + ": " + how);
                  changed.notify_all();
                }};
  }
  std::string wait_for_one() {
    std::unique_lock lock(mutex);
    changed.wait_for(lock, std::chrono::seconds(10), [this] { return !ended.empty(); });
    return ended.empty() ? "nothing" : ended.front();
  }
};

class LocalExecutorAdoption : public testing::Test {
protected:
  Adoption adopt(const std::string& handle, int attempt = 1, const std::string& job_id = "a-job") {
    return executor_.adopt(handle,
                           {.job_id = job_id, .attempt = attempt, .folder = folder_.path()});
  }

  TemporaryFolder folder_;
  Ends ends_;
  LocalExecutor executor_{"/bin/true", "", 1};
};

TEST_F(LocalExecutorAdoption, LeadsOnAWorkerThatClaimsTheFolder) {
  executor_.set_calls(ends_.calls());
  ClaimingProcess worker(folder_.path(), {.job_id = "a-job", .attempt = 1});
  EXPECT_EQ(adopt(handle_of(worker.id())), Adoption::found);
  executor_.kill("a-job", 1);
  EXPECT_EQ(ends_.wait_for_one(), "a-job 1: an end nobody saw");
  EXPECT_FALSE(holder_of(folder_.path()));
}

// The daemon died before it had stored the handle.
TEST_F(LocalExecutorAdoption, FindsAWorkerWithoutItsHandle) {
  executor_.set_calls(ends_.calls());
  ClaimingProcess worker(folder_.path(), {.job_id = "a-job", .attempt = 1});
  EXPECT_EQ(adopt(""), Adoption::found);
}

TEST_F(LocalExecutorAdoption, EndsAWorkerThatItCannotLeadOn) {
  const WorkerClaim right{.job_id = "a-job", .attempt = 2};
  WorkerClaim other_job = right, other_attempt = right, other_protocol = right;
  other_job.job_id = "another";
  other_attempt.attempt = 1;
  other_protocol.protocol = worker_protocol + 1;
  for (const WorkerClaim& claim : {other_job, other_attempt, other_protocol}) {
    ClaimingProcess worker(folder_.path(), claim);
    EXPECT_EQ(adopt(handle_of(worker.id()), 2), Adoption::gone);
    EXPECT_FALSE(holder_of(folder_.path()));
  }
  ClaimingProcess worker(folder_.path(), right);
  EXPECT_EQ(adopt(handle_of(::getpid()) + "1", 2), Adoption::gone) << "the handle is of another";
  EXPECT_FALSE(holder_of(folder_.path()));
}

TEST_F(LocalExecutorAdoption, LeavesItToTheNextDaemonWhenTold) {
  executor_.set_calls(ends_.calls());
  ClaimingProcess worker(folder_.path(), {.job_id = "a-job", .attempt = 1});
  EXPECT_EQ(adopt(""), Adoption::found);
  executor_.let_workers_run();
  EXPECT_TRUE(holder_of(folder_.path()));
  EXPECT_TRUE(ends_.ended.empty());
}

// Without a claim a worker has not outlived its daemon: it could only hang.
TEST(LocalExecutor, EndsAWorkerOfAnEarlierDaemon) {
  LocalExecutor executor("/bin/true", "", 1);
  const pid_t worker = ::fork();
  if (worker == 0) {
    ::pause();
    ::_exit(0);
  }
  const std::string handle = handle_of(worker);
  EXPECT_EQ(executor.adopt(handle, {.job_id = "a job", .attempt = 1}), Adoption::gone);
  EXPECT_FALSE(identify(worker));
  EXPECT_EQ(executor.adopt(handle, {.job_id = "a job", .attempt = 1}), Adoption::gone);
}

TEST(LocalExecutor, LeavesOthersAloneThatHaveTheNumberOfAWorker) {
  LocalExecutor executor("/bin/true", "", 1);
  const WorkerLaunch launch{.job_id = "a job", .attempt = 1};
  const std::string reused = std::to_string(::getpid()) + " 1";
  for (const std::string& handle : {reused, std::string(), std::string("node7 of a cluster")})
    EXPECT_EQ(executor.adopt(handle, launch), Adoption::gone);
}

}  // namespace
}  // namespace dccast::jobs
