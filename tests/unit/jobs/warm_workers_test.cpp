#include "server/jobs/executors/warm_workers.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "server/jobs/processes.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

using Why = WorkerDidNotAnswer::Why;

// A worker program: does what the first text of its request says, with the number of the process
// before the answer.
constexpr const char* program_text = R"(#!/usr/bin/python3
import os, signal, socket, sys, time
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
def read_varint(take):
    value = shift = 0
    while True:
        byte = take(1)[0]
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128: return value
def varint(value):
    more = b""
    while value > 127: more += bytes([value & 127 | 128]); value >>= 7
    return more + bytes([value])
def field(number, data): return bytes([number << 3 | 2]) + varint(len(data)) + data
class Message:
    def __init__(self, data): self.data, self.at = data, 0
    def take(self, size):
        self.at += size
        return self.data[self.at - size:self.at]
    def field(self):
        number = self.take(1)[0] >> 3
        return number, self.take(read_varint(self.take))
def send(answer): link.sendall(varint(len(answer)) + answer)
while True:
    kind, request = Message(receive(read_varint(receive))).field()
    text = Message(request).field()[1] if request else b""
    if text == b"abort": os.abort()
    if text == b"killed": os.kill(os.getpid(), signal.SIGKILL)
    if text == b"leave": sys.exit(3)
    if text == b"hang": time.sleep(1000)  # it is killed
    if text == b"grow": held.append(b"x" * 300000000); time.sleep(1000)  # it is killed
    if text == b"nonsense": link.sendall(b"\xff" * 16)
    if kind == 4:
        for event in range(1, 1001): send(field(1, b"\x08" + varint(event)))
    answer = b"%d " % os.getpid() + text
    send(field(2 if text == b"refuse" else 6, answer))
)";

v1::WorkerRequest request_of(const std::string& question) {
  v1::WorkerRequest request;
  request.mutable_check()->add_faulty_keys(question);
  return request;
}

class WarmWorkersTest : public testing::Test {
protected:
  WarmWorkersTest() {
    std::ofstream(program_) << program_text;
    std::filesystem::permissions(program_, std::filesystem::perms::owner_all);
  }
  /// @return the number of the process that answered, and its answer
  static std::pair<pid_t, std::string> ask(
      WarmWorkers& workers, const std::string& question,
      const CallLimits& limits = in(std::chrono::seconds(20))) {
    const std::string answer = workers.ask(request_of(question), limits).solver();
    const auto blank = answer.find(' ');
    return {std::stoi(answer.substr(0, blank)), answer.substr(blank + 1)};
  }
  static CallLimits in(std::chrono::milliseconds time) {
    return {.deadline = std::chrono::steady_clock::now() + time};
  }
  static Why reason(WarmWorkers& workers, const std::string& question,
                    const CallLimits& limits = in(std::chrono::seconds(20))) {
    try {
      ask(workers, question, limits);
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

TEST_F(WarmWorkersTest, OneAnswersManyRequestsWhateverTheirSize) {
  WarmWorkers workers(program_);
  const auto [process, answer] = ask(workers, "first");
  EXPECT_EQ(answer, "first");
  const std::string large(3000000, 'q');
  EXPECT_EQ(ask(workers, large), std::pair(process, large));
  EXPECT_EQ(ask(workers, ""), std::pair(process, std::string()));
}

TEST_F(WarmWorkersTest, EventsComeInOrderBeforeTheEnd) {
  WarmWorkers workers(program_);
  v1::WorkerRequest request;
  request.mutable_solve()->set_directory("run");
  std::vector<std::int64_t> events;
  const auto answer =
      workers.ask(request, in(std::chrono::seconds(20)),
                  [&](const v1::JobEvent& event) { events.push_back(event.sequence()); });
  ASSERT_EQ(events.size(), 1000);
  for (std::int64_t i = 0; i < 1000; ++i) EXPECT_EQ(events[static_cast<std::size_t>(i)], i + 1);
  EXPECT_TRUE(answer.solver().ends_with(" run"));
}

/// The next question must not wait for the start of a program.
TEST_F(WarmWorkersTest, OneThatWasKilledIsReplacedAtOnce) {
  WarmWorkers workers(program_);
  EXPECT_EQ(reason(workers, "abort"), Why::died);
  ASSERT_TRUE(eventually([&] { return programs_begun() >= 2; }));
  std::ofstream(program_) << "no program any more";
  EXPECT_EQ(ask(workers, "again").second, "again");
}

TEST_F(WarmWorkersTest, AReplacementTakesOverAfterADeath) {
  WarmWorkers workers(program_);
  const pid_t process = ask(workers, "first").first;
  EXPECT_EQ(reason(workers, "abort"), Why::died);
  const pid_t second = ask(workers, "again").first;
  EXPECT_NE(second, process);
  EXPECT_EQ(reason(workers, "leave"), Why::died);
  EXPECT_EQ(reason(workers, "killed"), Why::killed);
  EXPECT_EQ(reason(workers, "nonsense"), Why::died);
  EXPECT_EQ(ask(workers, "again").second, "again");
}

TEST_F(WarmWorkersTest, ADeathBetweenTwoRequestsCostsNoAnswer) {
  WarmWorkers workers(program_);
  const pid_t process = ask(workers, "first").first;
  ::kill(process, SIGKILL);
  siginfo_t ended;
  ASSERT_EQ(::waitid(P_PID, static_cast<id_t>(process), &ended, WEXITED | WNOWAIT), 0);
  EXPECT_NE(ask(workers, "again").first, process);
}

TEST_F(WarmWorkersTest, ARefusalKeepsTheWorker) {
  WarmWorkers workers(program_);
  const pid_t process = ask(workers, "first").first;
  EXPECT_EQ(reason(workers, "refuse"), Why::refused);
  EXPECT_EQ(ask(workers, "again").first, process);
}

TEST_F(WarmWorkersTest, NoOneWaitsForEver) {
  WarmWorkers workers(program_);
  ask(workers, "first");
  EXPECT_EQ(reason(workers, "hang", in(std::chrono::milliseconds(100))), Why::too_slow);
  const auto begin = std::chrono::steady_clock::now();
  const CallLimits called_off{
      begin + std::chrono::hours(1),
      [&] { return std::chrono::steady_clock::now() > begin + std::chrono::milliseconds(50); }};
  EXPECT_EQ(reason(workers, "hang", called_off), Why::called_off);
}

TEST_F(WarmWorkersTest, OneThatGrowsIsStoppedAndOneThatLeaksReplaced) {
  WarmWorkers workers(program_);
  CallLimits tight = in(std::chrono::seconds(20));
  tight.largest_bytes = 200'000'000;
  EXPECT_EQ(reason(workers, "grow", tight), Why::too_large);
  WarmWorkers leaky(program_, {.idle_bytes = 1000});
  const pid_t process = ask(leaky, "first").first;
  EXPECT_NE(ask(leaky, "again").first, process);
}

TEST_F(WarmWorkersTest, OneIsReplacedAfterItsNumberOfAnswers) {
  WarmWorkers workers(program_, {.answers = 2});
  const pid_t process = ask(workers, "1").first;
  EXPECT_EQ(ask(workers, "2").first, process);
  EXPECT_NE(ask(workers, "3").first, process);
}

// Where the system ignores SIGCHLD it collects children itself, and waitpid() knows nothing of
// them.
TEST_F(WarmWorkersTest, AnEndThatCannotBeLearnedIsNoSuccess) {
  WarmWorkers workers(program_);
  const auto before = ::signal(SIGCHLD, SIG_IGN);
  EXPECT_EQ(reason(workers, "leave"), Why::died);
  ::signal(SIGCHLD, before);
}

TEST_F(WarmWorkersTest, SaysWhatIsMissing) {
  WarmWorkers workers(folder_.path() / "none");
  EXPECT_EQ(reason(workers, "first"), Why::not_started);
  EXPECT_THROW(workers.take(), WorkerDidNotAnswer);
}

/// One that is given a job is not missed by those who ask.
TEST_F(WarmWorkersTest, OneThatIsTakenIsReplaced) {
  WarmWorkers workers(program_, {.kept = 1});
  const auto taken = workers.take();
  ASSERT_TRUE(eventually([&] { return programs_begun() >= 2; }));
  std::ofstream(program_) << "no program any more";
  EXPECT_EQ(ask(workers, "first").second, "first");
  EXPECT_FALSE(taken->exit());
  taken->signal(SIGKILL);
  EXPECT_TRUE(eventually([&] { return taken->exit().has_value(); }));
}

/// Reading for an answer may have changed it.
TEST_F(WarmWorkersTest, OneThatHasAnsweredGetsNoJob) {
  WarmWorkers workers(program_, {.kept = 1});
  const pid_t process = ask(workers, "first").first;
  const auto taken = workers.take();
  EXPECT_EQ(taken->answers(), 0);
  const auto answer =
      taken->ask(request_of("job"), in(std::chrono::seconds(20)), [](const v1::JobEvent&) {});
  EXPECT_NE(std::stoi(answer.solver()), process);
  EXPECT_EQ(ask(workers, "again").first, process);
}

TEST(FolderOf, EachKindOfRequestHasItsOwn) {
  EXPECT_EQ(folder_of(request_of("check")), "") << "a case without files";
  v1::WorkerRequest request;
  request.mutable_check()->set_directory("a");
  EXPECT_EQ(folder_of(request), "a");
  request.mutable_solve()->set_directory("b");
  EXPECT_EQ(folder_of(request), "b");
  request.mutable_write_table()->set_path("c/study.h5");
  EXPECT_EQ(folder_of(request), "c");
}

/// It can read the folder of that job, and what it read may have taken it over.
TEST_F(WarmWorkersTest, OneThatHasReadTheFolderOfAJobServesNothingElse) {
  WarmWorkers workers(program_, {.kept = 2});
  const auto process_of = [&](const v1::WorkerRequest& request) {
    const std::string answer = workers.ask(request, in(std::chrono::seconds(20))).solver();
    return std::stoi(answer.substr(0, answer.find(' ')));
  };
  const auto frame_of = [](const std::string& job) {
    v1::WorkerRequest request;
    request.mutable_read_frame()->set_directory(job);
    return request;
  };
  v1::WorkerRequest probe;
  probe.mutable_probe_frames()->set_directory("a");

  const pid_t of_a = process_of(frame_of("a"));
  const pid_t of_checks = process_of(request_of("check"));
  EXPECT_NE(of_checks, of_a);
  EXPECT_EQ(process_of(probe), of_a);
  EXPECT_EQ(process_of(request_of("check")), of_checks);

  // A third kind takes the place of the one that has waited longest.
  const pid_t of_b = process_of(frame_of("b"));
  EXPECT_NE(of_b, of_a);
  EXPECT_NE(of_b, of_checks);
  EXPECT_EQ(process_of(request_of("check")), of_checks);
  EXPECT_NE(process_of(frame_of("a")), of_a);
}

TEST(Processes, AnEndIsDescribedInWords) {
  EXPECT_EQ(describe_exit(SIGKILL), "signal 9 (Killed)");
  EXPECT_EQ(describe_exit(3 << 8), "exit code 3");
}

}  // namespace
}  // namespace dccast::jobs
