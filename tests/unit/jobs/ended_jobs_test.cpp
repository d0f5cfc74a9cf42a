#include "server/jobs/queue/ended_jobs.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>

#include "core/storage/file.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

class EndHookTest : public testing::Test {
protected:
  /// A script that first adds a line to `lines`.
  std::string program(const std::string& rest) {
    const auto path = folder_.path() / "hook";
    storage::write_file(path,
                        "#!/bin/sh\necho \"$2 $DCCAST_OWNER\" >>" + lines().string() + "\n" + rest);
    ::chmod(path.c_str(), 0700);
    return path;
  }
  std::filesystem::path lines() const { return folder_.path() / "lines"; }
  std::string text() const {
    return std::filesystem::exists(lines()) ? storage::read_file(lines()) : "";
  }
  bool becomes(const std::string& wanted) const {
    return eventually([&] { return text() == wanted; });
  }
  static v1::Job job(v1::JobState state, const std::string& owner) {
    v1::Job job;
    job.set_id("0f2b9a4e");
    job.set_state(state);
    job.set_owner(owner);
    return job;
  }

  TemporaryFolder folder_;
};

TEST_F(EndHookTest, OnlyAnEndIsReportedAndOnce) {
  EndHook hook(program(""));
  hook.on_transition(job(v1::RUNNING, "anna"), v1::QUEUED);
  hook.on_transition(job(v1::SUCCEEDED, "anna"), v1::RUNNING);
  hook.on_transition(job(v1::SUCCEEDED, "anna"), v1::SUCCEEDED);
  hook.on_transition(job(v1::FAILED, "$(id) ben"), v1::RUNNING);
  EXPECT_TRUE(becomes("SUCCEEDED anna\nFAILED $(id) ben\n")) << text();
}

TEST_F(EndHookTest, AProgramThatHangsIsKilledWithItsChildrenAndTheNextJobIsReported) {
  EndHook hook(program("sleep 1000 & wait\n"), std::chrono::seconds(1));
  hook.on_transition(job(v1::SUCCEEDED, "anna"), v1::RUNNING);
  hook.on_transition(job(v1::CANCELLED, "ben"), v1::QUEUED);
  EXPECT_TRUE(becomes("SUCCEEDED anna\nCANCELLED ben\n")) << text();
}

TEST_F(EndHookTest, TheDaemonsEndDoesNotWaitForIt) {
  const auto begin = std::chrono::steady_clock::now();
  {
    EndHook hook(program("sleep 1000\n"));
    hook.on_transition(job(v1::SUCCEEDED, "anna"), v1::RUNNING);
    EXPECT_TRUE(becomes("SUCCEEDED anna\n"));
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60))
      << "the program was waited for to its own limit";
}

TEST_F(EndHookTest, AProgramThatIsGoneEndsNothing) {
  EndHook hook((folder_.path() / "nowhere").string());
  hook.on_transition(job(v1::SUCCEEDED, "anna"), v1::RUNNING);
  EndHook none("");
  none.on_transition(job(v1::SUCCEEDED, "anna"), v1::RUNNING);
}

}  // namespace
}  // namespace dccast::jobs
