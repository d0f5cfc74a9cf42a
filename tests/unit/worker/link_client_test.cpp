#include "server/worker/link_client.hpp"

#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <string>
#include <thread>

namespace dccast::worker {
namespace {

using namespace std::chrono_literals;

/// A daemon's end of the link that starts a worker with heartbeats and then does what a test wants.
class Daemon : public v1::WorkerLink::Service {
public:
  using Stream = grpc::ServerReaderWriter<v1::WorkerOrder, v1::WorkerMessage>;

  Daemon() {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    address = "127.0.0.1:" + std::to_string(port);
  }
  ~Daemon() override { server_->Shutdown(std::chrono::system_clock::now() + 1s); }

  grpc::Status Run(grpc::ServerContext*, Stream* stream) override {
    v1::WorkerMessage message;
    stream->Read(&message);
    v1::WorkerOrder order;
    order.mutable_start()->set_heartbeat_interval_s(heartbeat_interval_s);
    stream->Write(order);
    if (!reads) {
      let_go.get_future().wait();
      return grpc::Status::OK;
    }
    while (stream->Read(&message)) {
      if (message.has_heartbeat() && ++beats == 3) alive.set_value();
      if (finished && message.has_heartbeat()) ++beats_after_the_end;
      if (!message.has_finished()) continue;
      finished = true;
      std::this_thread::sleep_for(100ms);  // in which a heart would beat on
      v1::WorkerOrder acknowledgement;
      acknowledgement.mutable_acknowledged();
      stream->Write(acknowledgement);
    }
    return grpc::Status::OK;
  }

  std::string address;
  double heartbeat_interval_s = 0.02;
  bool reads = true;
  bool finished = false;
  int beats = 0;
  int beats_after_the_end = 0;
  std::promise<void> alive;   ///< after three heartbeats
  std::promise<void> let_go;  ///< by the test, of a daemon that does not read

private:
  std::unique_ptr<grpc::Server> server_;
};

TEST(LinkClient, SaysThatItIsAliveWhileAStepTakesLong) {
  Daemon daemon;
  {
    LinkClient link(daemon.address);
    ASSERT_TRUE(link.begin({}));
    EXPECT_EQ(daemon.alive.get_future().wait_for(10s), std::future_status::ready);
    EXPECT_TRUE(link.finish({}));
  }
  EXPECT_EQ(daemon.beats_after_the_end, 0) << "Finished is the last word";
}

TEST(LinkClient, IsSilentWhereNoHeartbeatIsAsked) {
  Daemon daemon;
  daemon.heartbeat_interval_s = 0.0;
  LinkClient link(daemon.address);
  ASSERT_TRUE(link.begin({}));
  std::this_thread::sleep_for(100ms);
  EXPECT_TRUE(link.finish({}));
  EXPECT_EQ(daemon.beats, 0);
}

TEST(LinkClient, LeavesADaemonThatDoesNotRead) {
  Daemon daemon;
  daemon.reads = false;
  auto link = std::make_unique<LinkClient>(daemon.address);
  ASSERT_TRUE(link->begin({}));
  v1::WorkerMessage large;
  large.mutable_message()->set_text(std::string(1 << 20, 'x'));
  for (int i = 0; i < 32; ++i) link->send(large);  // more than the connection takes unread
  std::this_thread::sleep_for(100ms);              // the sender is in the middle of it
  auto left = std::async(std::launch::async, [&] { link.reset(); });
  EXPECT_EQ(left.wait_for(10s), std::future_status::ready);
  daemon.let_go.set_value();
}

}  // namespace
}  // namespace dccast::worker
