#pragma once

#include <grpcpp/client_context.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "dccast/v1/worker.grpc.pb.h"
#include "server/jobs/socket_path.hpp"
#include "server/worker/outbox.hpp"
#include "server/worker/run_link.hpp"

namespace dccast::worker {

/// The worker's end of the link to its daemon. A thread sends, a thread receives; the run itself
/// only leaves messages here and looks at an atomic. The thread that sends also says at intervals
/// that the process is alive, however long a step takes.
///
/// A link that ends ends the process, unless outlive_daemon() was called: then the thread that
/// receives calls the next daemon, and says again what that one lacks.
class LinkClient : public RunLink {
public:
  using Clock = std::chrono::steady_clock;

  explicit LinkClient(const std::string& address);
  /// Drops what is not sent yet: a daemon that does not read must not keep a worker. finish() is
  /// what waits for it.
  ~LinkClient() override;

  /// Calls the daemon. @return what to run; nothing when the daemon is gone or refuses
  std::optional<v1::WorkerOrder::Start> begin(const v1::WorkerMessage::Hello& hello);
  /// From now on the run goes on without a daemon, before anything is sent.
  /// @param patience  after so long without one the run is told to stop at a checkpoint
  /// @param wanted    whether the folder of the job is there for this run; asked while there is no
  ///                  daemon: the process ends when it is not
  void outlive_daemon(Clock::duration patience, std::function<bool()> wanted);
  /// Leaves a message to be sent. Waits only when the daemon is thousands of messages behind.
  void send(v1::WorkerMessage message) override;
  /// What the run is told to do; also after SIGTERM.
  casting::Order order() const override;
  /// Sends the last message. @return whether the daemon has acknowledged it
  bool finish(v1::WorkerMessage::Finished finished);

private:
  /// One call of a daemon.
  struct Call {
    grpc::ClientContext context;
    std::unique_ptr<grpc::ClientReaderWriter<v1::WorkerMessage, v1::WorkerOrder>> stream;
    bool writing = false;  ///< of the mutex
  };
  /// What is to be written next, and where.
  struct Turn {
    std::shared_ptr<Call> call;
    std::vector<v1::WorkerMessage> messages;
  };

  std::optional<v1::WorkerOrder::Start> greet(Call& call);

  // The thread that sends.
  void run_sender();
  std::optional<Turn> next_turn();
  Clock::time_point next_wake() const;
  void look_at_patience();
  bool write(const Turn& turn);

  // The thread that receives.
  void run_receiver(std::shared_ptr<Call> call);
  void obey(const v1::WorkerOrder& order);
  grpc::Status read_orders(const std::shared_ptr<Call>& call);
  void lose(const std::shared_ptr<Call>& call);
  std::shared_ptr<Call> next_call();
  bool reach_daemon() const;
  std::shared_ptr<Call> call_next_daemon();
  bool take_up(const std::shared_ptr<Call>& call, const v1::WorkerOrder::Start& start);
  void require_another_call(const grpc::Status& status);
  void set_heartbeat(const v1::WorkerOrder::Start& start);
  bool is_over() const { return acknowledged_ || closed_; }
  bool waits_in_vain() const;

  const jobs::SocketPath socket_;
  const std::shared_ptr<grpc::Channel> channel_;
  const std::unique_ptr<v1::WorkerLink::Stub> stub_;
  v1::WorkerMessage::Hello hello_;
  std::atomic<casting::Order> order_{casting::Order::go_on};
  std::mutex mutex_;  ///< of all below
  std::condition_variable changed_;
  Outbox outbox_;
  std::shared_ptr<Call> call_;     ///< null while there is no daemon
  std::shared_ptr<Call> calling_;  ///< to a daemon that has not answered yet
  Clock::duration heartbeat_{};    ///< zero: none
  Clock::time_point beat_{};       ///< the next one
  Clock::duration patience_{};     ///< zero: the process ends with its link
  std::function<bool()> wanted_;
  Clock::time_point lost_at_{};  ///< when the daemon went, while there is none
  bool gave_up_ = false;         ///< no daemon came in time
  bool closed_ = false;          ///< nothing more is sent
  bool acknowledged_ = false;
  std::thread sender_;
  std::thread receiver_;
};

}  // namespace dccast::worker
