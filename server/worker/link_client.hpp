#pragma once

#include <grpcpp/client_context.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "dccast/v1/worker.grpc.pb.h"
#include "server/worker/run_link.hpp"

namespace dccast::worker {

/// The worker's end of the link to its daemon. A thread sends, a thread receives; the run itself
/// only leaves messages here and looks at an atomic. The thread that sends also says at intervals
/// that the process is alive, however long a step takes.
class LinkClient : public RunLink {
public:
  explicit LinkClient(const std::string& address);
  /// Drops what is not sent yet: a daemon that does not read must not keep a worker. finish() is
  /// what waits for it.
  ~LinkClient() override;

  /// Calls the daemon. @return what to run; nothing when the daemon is gone or refuses
  std::optional<v1::WorkerOrder::Start> begin(const v1::WorkerMessage::Hello& hello);
  /// Leaves a message to be sent. Waits only when the daemon is thousands of messages behind.
  void send(v1::WorkerMessage message) override;
  /// What the run is told to do; also after SIGTERM.
  casting::Order order() const override;
  /// Sends the last message. @return whether the daemon has acknowledged it
  bool finish(v1::WorkerMessage::Finished finished);

private:
  using Clock = std::chrono::steady_clock;

  /// @param heartbeat  interval; zero: none
  void run_sender(Clock::duration heartbeat);
  void run_receiver();
  /// Waits for messages, until `beat` at the longest; nothing once all is sent and the link closed.
  std::optional<std::deque<v1::WorkerMessage>> take_outgoing(Clock::time_point beat);
  /// @return whether the daemon can still be reached
  bool write(const std::deque<v1::WorkerMessage>& messages);

  grpc::ClientContext context_;
  std::unique_ptr<v1::WorkerLink::Stub> stub_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::WorkerMessage, v1::WorkerOrder>> stream_;
  std::atomic<casting::Order> order_{casting::Order::go_on};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<v1::WorkerMessage> outgoing_;
  bool closed_ = false;  ///< nothing more is sent
  bool acknowledged_ = false;
  std::thread sender_;
  std::thread receiver_;
};

}  // namespace dccast::worker
