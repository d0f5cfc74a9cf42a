#include "server/jobs/local_executor.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "server/jobs/process.hpp"

namespace dccast::jobs {
namespace {

std::string handle_of(pid_t process) {
  return std::to_string(process) + " " + std::to_string(identify(process)->start_ticks);
}

// The link of a local worker has ended with its daemon: it could only hang.
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
