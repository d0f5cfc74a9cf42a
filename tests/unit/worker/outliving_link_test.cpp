// A worker that runs on while its daemon is away, and calls the next one.
#include <gmock/gmock.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/worker/link_client.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/worker/worker_messages.hpp"

namespace dccast::worker {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// What a daemon tells a worker that calls.
struct Reply {
  std::int64_t stored = 0;  ///< reports that it has
  grpc::Status refusal{};   ///< not OK: it does not take the worker
  double patience_s = 30.0;
};

/// A daemon's end of the link, on a socket that the next one takes over.
class Daemon : public v1::WorkerLink::Service {
public:
  using Stream = grpc::ServerReaderWriter<v1::WorkerOrder, v1::WorkerMessage>;

  explicit Daemon(const TemporaryFolder& folder, Reply reply = {}) : reply_(std::move(reply)) {
    std::filesystem::remove(folder / "link");
    grpc::ServerBuilder builder;
    builder.AddListeningPort(address(folder), grpc::InsecureServerCredentials());
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
  }
  ~Daemon() override { leave(); }
  void leave() { server_->Shutdown(std::chrono::system_clock::now()); }

  static std::string address(const TemporaryFolder& folder) {
    return "unix:" + (folder / "link").string();
  }

  grpc::Status Run(grpc::ServerContext*, Stream* stream) override {
    v1::WorkerMessage message;
    stream->Read(&message);
    note([&] { hello = message.hello(); });
    if (!reply_.refusal.ok()) return reply_.refusal;
    v1::WorkerOrder order;
    order.mutable_start()->set_heartbeat_interval_s(0.02);
    order.mutable_start()->set_daemon_patience_s(reply_.patience_s);
    order.mutable_start()->set_reports_stored(reply_.stored);
    stream->Write(order);
    while (stream->Read(&message)) {
      if (message.has_step()) note([&] { steps.push_back(message.step().step()); });
      if (!message.has_finished()) continue;
      v1::WorkerOrder acknowledgement;
      acknowledgement.mutable_acknowledged();
      stream->Write(acknowledgement);
    }
    return grpc::Status::OK;
  }

  /// @return whether it has heard so many steps, in time
  bool hears(std::size_t number) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, 10s, [&] { return steps.size() >= number; });
  }

  v1::WorkerMessage::Hello hello;
  std::vector<std::int64_t> steps;

private:
  void note(const std::function<void()>& what) {
    const std::lock_guard lock(mutex_);
    what();
    changed_.notify_all();
  }

  const Reply reply_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::unique_ptr<grpc::Server> server_;
};

class OutlivingLink : public testing::Test {
protected:
  /// A worker whose first daemon has heard steps 1 to 3 and is gone.
  std::unique_ptr<LinkClient> left_after_three_steps(std::chrono::milliseconds patience = 30s) {
    Daemon daemon(folder_);
    auto link = std::make_unique<LinkClient>(Daemon::address(folder_));
    v1::WorkerMessage::Hello hello;
    hello.set_token("a token");
    EXPECT_TRUE(link->begin(hello));
    link->outlive_daemon(patience, [] { return true; });
    for (const std::int64_t number : {1, 2, 3}) link->send(step(number));
    EXPECT_TRUE(daemon.hears(3));
    EXPECT_FALSE(daemon.hello.running());
    return link;
  }

  TemporaryFolder folder_;
};

TEST_F(OutlivingLink, TellsTheNextDaemonWhatItLacks) {
  const auto link = left_after_three_steps();
  for (const std::int64_t number : {4, 5}) link->send(step(number));
  Daemon next(folder_, {.stored = 2});
  EXPECT_TRUE(next.hears(3));
  EXPECT_TRUE(link->finish({}));
  EXPECT_THAT(next.steps, ElementsAre(3, 4, 5));
  EXPECT_TRUE(next.hello.running());
  EXPECT_EQ(next.hello.token(), "a token");
}

TEST_F(OutlivingLink, KeepsItsLastWordForTheNextDaemon) {
  const auto link = left_after_three_steps();
  std::jthread daemon([this] {
    std::this_thread::sleep_for(300ms);
    Daemon next(folder_, {.stored = 3});
    std::this_thread::sleep_for(2s);
    EXPECT_THAT(next.steps, IsEmpty());
  });
  EXPECT_TRUE(link->finish({}));
}

TEST_F(OutlivingLink, GoesOnWithOneDaemonAfterTheOther) {
  const auto link = left_after_three_steps();
  for (const std::int64_t stored : {3, 4, 5}) {
    Daemon next(folder_, {.stored = stored});
    link->send(step(stored + 1));
    EXPECT_TRUE(next.hears(1));
    EXPECT_THAT(next.steps, ElementsAre(stored + 1));
  }
}

TEST_F(OutlivingLink, StopsTheRunWhenNoDaemonComes) {
  const auto link = left_after_three_steps(300ms);
  EXPECT_EQ(link->order(), casting::Order::go_on);
  const auto begin = std::chrono::steady_clock::now();
  while (link->order() == casting::Order::go_on) {
    ASSERT_LT(std::chrono::steady_clock::now(), begin + 10s);
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_GE(std::chrono::steady_clock::now(), begin + 200ms);
  EXPECT_EQ(link->order(), casting::Order::stop_at_checkpoint);
  EXPECT_FALSE(link->finish({})) << "nobody has heard it";
}

// More steps than are kept for a daemon that is away: the run waits, and does not for ever.
TEST_F(OutlivingLink, LetsARunThatWaitsForADaemonStop) {
  const auto link = left_after_three_steps(300ms);
  for (std::int64_t number = 4; number < 6000; ++number) link->send(step(number));
  EXPECT_EQ(link->order(), casting::Order::stop_at_checkpoint);
}

// Such a daemon does not say what it has stored.
TEST_F(OutlivingLink, KeepsNothingForADaemonWhoseWorkersEndWithIt) {
  constexpr std::int64_t last = 9000;
  const auto link = left_after_three_steps();
  Daemon next(folder_, {.stored = 3, .patience_s = 0.0});
  for (std::int64_t number = 4; number <= last; ++number) link->send(step(number));
  EXPECT_TRUE(next.hears(last - 3));
  EXPECT_TRUE(link->finish({}));
}

using OutlivingLinkDeathTest = OutlivingLink;

void wait_for_the_end() {
  std::this_thread::sleep_for(20s);
  ::_exit(0);
}

// The run waits for room, and nobody else would tell it.
TEST_F(OutlivingLinkDeathTest, LetsARunThatWaitsForADaemonLeaveAtSigterm) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const auto link = left_after_three_steps();
        std::jthread signals([] {
          std::this_thread::sleep_for(1s);
          ::kill(::getpid(), SIGTERM);
        });
        for (std::int64_t number = 4; number < 6000; ++number) link->send(step(number));
        ::_exit(link->order() == casting::Order::stop_at_checkpoint ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST_F(OutlivingLinkDeathTest, EndsWhenTheNextDaemonDoesNotKnowIt) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const auto link = left_after_three_steps();
        Daemon next(folder_, {.refusal = {grpc::StatusCode::PERMISSION_DENIED, "no such attempt"}});
        wait_for_the_end();
      },
      testing::ExitedWithCode(70), "no such attempt");
}

TEST_F(OutlivingLinkDeathTest, EndsWhenTheNextDaemonLacksWhatIsGone) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const auto link = left_after_three_steps();
        Daemon next(folder_, {.stored = 9});
        wait_for_the_end();
      },
      testing::ExitedWithCode(70), "no longer here");
}

TEST_F(OutlivingLinkDeathTest, EndsWhenItsFolderIsGone) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        Daemon daemon(folder_);
        LinkClient link(Daemon::address(folder_));
        link.begin({});
        link.outlive_daemon(30s, [] { return false; });
        daemon.leave();
        wait_for_the_end();
      },
      testing::ExitedWithCode(70), "folder of the job is gone");
}

}  // namespace
}  // namespace dccast::worker
