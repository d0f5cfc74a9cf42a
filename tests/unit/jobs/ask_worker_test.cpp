#include "server/jobs/ask_worker.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/unit/jobs/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

/// A worker program that is a shell script.
class AskWorker : public testing::Test {
protected:
  std::string ask(const std::string& script, const std::string& question) {
    const auto program = folder_.path() / "worker";
    std::ofstream(program) << "#!/bin/sh\n" << script << '\n';
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    return ask_worker(program, "--check", question, std::chrono::seconds(1));
  }
  TemporaryFolder folder_;
};

TEST_F(AskWorker, GivesTheAnswerWhateverItsSize) {
  const std::string question(3000000, 'q');
  EXPECT_EQ(ask("cat", question), question);
  EXPECT_EQ(ask("printf %s $1", ""), "--check");
}

TEST_F(AskWorker, SaysHowItDied) {
  try {
    ask("kill -SEGV $$", "");
    FAIL();
  } catch (const WorkerDidNotAnswer& error) {
    EXPECT_NE(std::string(error.what()).find("signal 11"), std::string::npos) << error.what();
  }
  EXPECT_THROW(ask("exit 1", ""), WorkerDidNotAnswer);
}

TEST_F(AskWorker, DoesNotWaitForEver) {
  EXPECT_THROW(ask("exec sleep 20", ""), WorkerDidNotAnswer);
}

TEST_F(AskWorker, SaysWhatIsMissing) {
  EXPECT_THROW(ask_worker(folder_.path() / "none", "--check", "", std::chrono::seconds(1)),
               WorkerDidNotAnswer);
}

}  // namespace
}  // namespace dccast::jobs
