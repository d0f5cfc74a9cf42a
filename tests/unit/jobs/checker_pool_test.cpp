#include "server/jobs/checker.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>

#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

using Why = WorkerDidNotAnswer::Why;

// A worker program: does what the question says, with the number of the process before the answer.
constexpr const char* program_text = R"(#!/usr/bin/python3
import os, signal, socket, struct, sys, time
link = socket.socket(fileno=0)
open(os.path.join(os.path.dirname(sys.argv[0]), "ready-%d" % os.getpid()), "w").close()
held = []
def receive(size):
    data = b""
    while len(data) < size:
        more = link.recv(size - len(data))
        if not more: sys.exit(0)
        data += more
    return data
while True:
    kind, size = struct.unpack("=II", receive(8))
    text = receive(size)
    outcome = 0
    if text == b"abort": os.abort()
    if text == b"killed": os.kill(os.getpid(), signal.SIGKILL)
    if text == b"leave": sys.exit(3)
    if text == b"hang": time.sleep(1000)
    if text == b"grow": held.append(b"x" * 300000000); time.sleep(1000)
    if text == b"nonsense": link.sendall(b"nonsense" * 2)
    if text == b"refuse": outcome = 1
    if kind == 6:
        for part in range(1000): link.sendall(struct.pack("=II", 2, 4) + struct.pack("=I", part))
    if kind == 2: text = b"frame"
    answer = b"%d " % os.getpid() + text
    link.sendall(struct.pack("=II", outcome, len(answer)) + answer)
)";

class CheckerPoolTest : public testing::Test {
protected:
  CheckerPoolTest() {
    std::ofstream(program_) << program_text;
    std::filesystem::permissions(program_, std::filesystem::perms::owner_all);
  }
  /// @return the number of the process that answered, and its answer
  static std::pair<pid_t, std::string> ask(
      CheckerPool& pool, const std::string& question,
      std::chrono::milliseconds time = std::chrono::seconds(20)) {
    const std::string answer =
        pool.ask(Question::check, question, {std::chrono::steady_clock::now() + time});
    const auto blank = answer.find(' ');
    return {std::stoi(answer.substr(0, blank)), answer.substr(blank + 1)};
  }
  static Why reason(CheckerPool& pool, const std::string& question,
                    std::chrono::milliseconds time = std::chrono::seconds(20)) {
    try {
      ask(pool, question, time);
    } catch (const WorkerDidNotAnswer& error) {
      return error.why();
    }
    ADD_FAILURE() << "was answered";
    return Why::refused;
  }

  /// Programs that are past reading their own text.
  long programs_begun() const {
    return std::ranges::count_if(
        std::filesystem::directory_iterator(folder_.path()),
        [](const auto& entry) { return entry.path().filename().string().starts_with("ready-"); });
  }

  TemporaryFolder folder_;
  std::filesystem::path program_ = folder_.path() / "worker";
};

TEST_F(CheckerPoolTest, OneCheckerAnswersManyQuestionsWhateverTheirSize) {
  CheckerPool pool(program_);
  const auto [process, answer] = ask(pool, "first");
  EXPECT_EQ(answer, "first");
  const std::string large(3000000, 'q');
  EXPECT_EQ(ask(pool, large), std::pair(process, large));
  EXPECT_EQ(ask(pool, ""), std::pair(process, std::string()));
}

TEST_F(CheckerPoolTest, PartsOfAnAnswerComeInOrderBeforeItsEnd) {
  CheckerPool pool(program_);
  std::vector<std::uint32_t> parts;
  const std::string answer = pool.ask(
      Question::query, "run", {std::chrono::steady_clock::now() + std::chrono::seconds(20)},
      [&](std::string_view part) {
        ASSERT_EQ(part.size(), sizeof(std::uint32_t));
        std::memcpy(&parts.emplace_back(), part.data(), part.size());
      });
  ASSERT_EQ(parts.size(), 1000);
  for (std::uint32_t i = 0; i < 1000; ++i) EXPECT_EQ(parts[i], i);
  EXPECT_TRUE(answer.ends_with(" run"));
}

/// The next question must not wait for the start of a program.
TEST_F(CheckerPoolTest, OneThatWasKilledIsReplacedAtOnce) {
  CheckerPool pool(program_);
  EXPECT_EQ(reason(pool, "abort"), Why::died);
  while (programs_begun() < 2) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  std::ofstream(program_) << "no program any more";
  EXPECT_EQ(ask(pool, "again").second, "again");
}

TEST_F(CheckerPoolTest, AReplacementTakesOverAfterADeath) {
  CheckerPool pool(program_);
  const pid_t process = ask(pool, "first").first;
  EXPECT_EQ(reason(pool, "abort"), Why::died);
  const pid_t second = ask(pool, "again").first;
  EXPECT_NE(second, process);
  EXPECT_EQ(reason(pool, "leave"), Why::died);
  EXPECT_EQ(reason(pool, "killed"), Why::killed);
  EXPECT_EQ(reason(pool, "nonsense"), Why::died);
  EXPECT_EQ(ask(pool, "again").second, "again");
}

TEST_F(CheckerPoolTest, ADeathBetweenTwoQuestionsCostsNoAnswer) {
  CheckerPool pool(program_);
  const pid_t process = ask(pool, "first").first;
  ::kill(process, SIGKILL);
  siginfo_t ended;
  ASSERT_EQ(::waitid(P_PID, static_cast<id_t>(process), &ended, WEXITED | WNOWAIT), 0);
  EXPECT_NE(ask(pool, "again").first, process);
}

TEST_F(CheckerPoolTest, ARefusalKeepsTheChecker) {
  CheckerPool pool(program_);
  const pid_t process = ask(pool, "first").first;
  EXPECT_EQ(reason(pool, "refuse"), Why::refused);
  EXPECT_EQ(ask(pool, "again").first, process);
}

TEST_F(CheckerPoolTest, NobodyWaitsForEver) {
  CheckerPool pool(program_);
  ask(pool, "first");
  EXPECT_EQ(reason(pool, "hang", std::chrono::milliseconds(100)), Why::too_slow);
  const auto begin = std::chrono::steady_clock::now();
  const CallLimits called_off{
      begin + std::chrono::hours(1),
      [&] { return std::chrono::steady_clock::now() > begin + std::chrono::milliseconds(50); }};
  try {
    pool.ask(Question::check, "hang", called_off);
    FAIL();
  } catch (const WorkerDidNotAnswer& error) {
    EXPECT_EQ(error.why(), Why::called_off);
  }
}

TEST_F(CheckerPoolTest, OneThatGrowsIsStoppedAndOneThatLeaksReplaced) {
  CheckerPool tight(program_, {.largest_bytes = 200'000'000});
  EXPECT_EQ(reason(tight, "grow"), Why::too_large);
  CheckerPool leaky(program_, {.idle_bytes = 1000});
  const pid_t process = ask(leaky, "first").first;
  EXPECT_NE(ask(leaky, "again").first, process);
}

TEST_F(CheckerPoolTest, ACheckerIsReplacedAfterItsNumberOfAnswers) {
  CheckerPool pool(program_, {.answers = 2});
  const pid_t process = ask(pool, "1").first;
  EXPECT_EQ(ask(pool, "2").first, process);
  EXPECT_NE(ask(pool, "3").first, process);
}

// Where the system ignores SIGCHLD it collects children itself, and waitpid() knows nothing of
// them.
TEST_F(CheckerPoolTest, AnEndThatCannotBeLearnedIsNoSuccess) {
  CheckerPool pool(program_);
  const auto before = ::signal(SIGCHLD, SIG_IGN);
  EXPECT_EQ(reason(pool, "leave"), Why::died);
  ::signal(SIGCHLD, before);
}

TEST_F(CheckerPoolTest, SaysWhatIsMissing) {
  CheckerPool pool(folder_.path() / "none");
  EXPECT_EQ(reason(pool, "first"), Why::not_started);
}

}  // namespace
}  // namespace dccast::jobs
