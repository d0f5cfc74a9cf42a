#include "server/jobs/process.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace dccast::jobs {
namespace {

pid_t sleeping_child() {
  const pid_t child = ::fork();
  if (child == 0) {
    ::pause();
    ::_exit(0);
  }
  return child;
}

TEST(Process, IsIdentifiedByIdAndStartTime) {
  const auto self = identify(::getpid());
  ASSERT_TRUE(self);
  EXPECT_EQ(self->id, ::getpid());
  EXPECT_GT(self->start_ticks, 0u);
  EXPECT_EQ(identify(::getpid())->start_ticks, self->start_ticks);
}

TEST(Process, AnEndIsDescribedInWords) {
  const pid_t child = sleeping_child();
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(describe_exit(status), "signal 9 (Killed)");
  EXPECT_EQ(describe_exit(3 << 8), "exit code 3");
}

}  // namespace
}  // namespace dccast::jobs
