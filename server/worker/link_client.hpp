#pragma once

#include <grpcpp/client_context.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/casting/step_observer.hpp"
#include "dccast/v1/worker.grpc.pb.h"

namespace dccast::worker {

/// The worker's end of the link to its daemon. A thread sends, a thread receives; the run itself
/// only leaves messages here and looks at an atomic.
class LinkClient {
public:
  explicit LinkClient(const std::string& address);
  ~LinkClient();

  /// Calls the daemon. @return what to run; nothing when the daemon is gone or refuses
  std::optional<v1::WorkerOrder::Start> begin(const v1::WorkerMessage::Hello& hello);
  /// Leaves a message to be sent. Waits only when the daemon is thousands of messages behind.
  void send(v1::WorkerMessage message);
  /// What the run shall do; also after SIGTERM.
  casting::Order order() const;
  /// Sends the last message. @return whether the daemon has acknowledged it
  bool finish(v1::WorkerMessage::Finished finished);

private:
  void run_sender();
  void run_receiver();

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
