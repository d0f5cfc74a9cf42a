#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "client/session/failure.hpp"
#include "dccast/v1/service.grpc.pb.h"

namespace dccast::client {

/// The command was interrupted; the message states what happened to its work.
class Interrupted : public CommandFailed {
public:
  /// @param rest  what happened to the work, for the message
  explicit Interrupted(const std::string& rest)
      : CommandFailed(ExitCode::interrupted, "interrupted" + (rest.empty() ? "" : "; " + rest)) {}
};

/// A request to end the command, made by another thread. The command notices it because its calls
/// end early, and so leaves in an orderly way, with files closed and lines completed.
class Interruption {
public:
  /// Cancels the current call and every later one.
  void come();
  /// Whether the command is to end.
  bool came() const;
  /// Sleeps for `time`. Throws Interrupted.
  void sleep(std::chrono::milliseconds time);
  /// The command has written all it has to say; the process may take a while longer to end with
  /// this exit code.
  void end_command(int code) { exit_code_ = code; }
  int exit_code() const { return exit_code_; }  ///< negative: the command goes on

  /// During its lifetime an interruption cancels this call. Only one may exist at a time.
  class Call {
  public:
    /// @param context  of a call that is about to begin
    Call(Interruption& interruption, grpc::ClientContext& context);
    Call(const Call&) = delete;
    ~Call();

  private:
    Interruption& interruption_;
  };

private:
  /// Guards all members but the exit code.
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool came_ = false;
  std::atomic<int> exit_code_ = -1;
  grpc::ClientContext* call_ = nullptr;
};

/// Handles SIGINT and SIGTERM from now on in a thread of its own; must be called before other
/// threads start. A command that has not ended one second after the first signal, or at the second
/// signal, is terminated.
void interrupt_by_signals(std::shared_ptr<Interruption> interruption);

/// The service as an interface, so that tests can replace it.
using Stub = v1::SimulationService::StubInterface;
/// A unary call of the service: &Stub::GetJob.
template <typename Request, typename Response>
using Method = grpc::Status (Stub::*)(grpc::ClientContext*, const Request&, Response*);

/// Number of attempts of a repeatable call, and the pauses between them.
struct CallPolicy {
  /// Attempts in all, the first one included.
  int attempts = 4;
  std::chrono::milliseconds first_pause{200};  ///< doubled after every attempt
};

/// Port of a daemon over TLS whose address names none.
inline constexpr const char* default_port = ":7118";

/// The address with the port of dccastd where none is given. Throws CommandFailed for a URL.
std::string address_of(const std::string& server);

/// Where a daemon is and what it knows us by. Texts are PEM where nothing else is stated.
struct Endpoint {
  std::string address;               ///< with its port
  std::string ca{};                  ///< trusted alone; empty: there is no TLS
  std::string token{};               ///< of `dccast login`; not PEM
  std::string certificate{}, key{};  ///< of this client; empty: none
  /// Set by dccast-web: the browser that a call of this machine is made for, as gRPC writes
  /// addresses. The daemon then asks for the token of its user.
  std::string browser{};
  /// Whether the users of this machine call there, known by their socket.
  bool is_local() const { return ca.empty() && address.starts_with("unix:"); }
};

/// Connection to a daemon. It is established by the first call, and never through a proxy:
/// http_proxy and similar variables are ignored.
class Connection {
public:
  /// Does not connect yet. Throws CommandFailed for a certificate that cannot be used.
  explicit Connection(Endpoint endpoint, std::shared_ptr<Interruption> interruption =
                                             std::make_shared<Interruption>());
  /// The same connection, for another thread or after an interruption.
  Connection another(std::shared_ptr<Interruption> interruption) const {
    return Connection(endpoint_, channel_, std::move(interruption));
  }

  Stub& stub() { return *stub_; }
  /// What calls of the service by their names go over.
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }
  const std::string& server() const { return endpoint_.address; }
  /// Whether it is one of dccast-web.
  bool is_for_browser() const { return !endpoint_.browser.empty(); }
  /// Must be observed by any code that waits for this server, during or between calls.
  Interruption& interruption() { return *interruption_; }

  /// Makes a repeatable unary call (see try_call). Throws CommandFailed for any status but OK.
  template <typename Request, typename Response>
  Response call(Method<Request, Response> method, const Request& request) {
    Response response;
    check(try_call(method, request, response), server());
    return response;
  }

  /// The same about a job or a study, for a request that has no more than its id.
  template <typename Request, typename Response>
  Response call(Method<Request, Response> method, const std::string& id) {
    Request request;
    request.set_id(id);
    return call(method, request);
  }

  /// The same for a call that must not be repeated, because a second one would have a different
  /// result, such as resuming or deleting a job.
  template <typename Request, typename Response>
  Response call_once(Method<Request, Response> method, const Request& request) {
    Response response;
    check(try_once(method, request, response), server());
    return response;
  }

  /// One attempt at a call, with a deadline. @return its status. Throws Interrupted.
  template <typename Request, typename Response>
  grpc::Status try_once(Method<Request, Response> method, const Request& request,
                        Response& response) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + deadline);
    const Interruption::Call call(*interruption_, context);
    const grpc::Status status = (stub_.get()->*method)(&context, request, &response);
    if (!status.ok() && interruption_->came()) throw Interrupted("");
    return status;
  }

  /// A unary call with a deadline, repeated with increasing pauses while the server is UNAVAILABLE,
  /// with a message on standard error. For repeatable calls: all that only read, SubmitJob with its
  /// request id, CancelJob. @return the status of the last attempt. Throws Interrupted.
  template <typename Request, typename Response>
  grpc::Status try_call(Method<Request, Response> method, const Request& request,
                        Response& response) {
    const auto attempt = [&] { return try_once(method, request, response); };
    const grpc::Status status = with_retries(attempt);
    if (!restore_ || !is_refused(status, v1::ErrorInfo::ATTACHMENT_MISSING)) return status;
    restore_(*this);
    return with_retries(attempt);
  }

  /// Repeats a call with increasing pauses while the server is UNAVAILABLE, with a message on
  /// standard error. @return the status of the last attempt. Throws Interrupted.
  grpc::Status with_retries(const std::function<grpc::Status()>& attempt);

  /// Uploads again what a call names and the server may have lost.
  void set_restore(std::function<void(Connection&)> restore) { restore_ = std::move(restore); }

  /// For tests, which cannot wait.
  void set_policy(const CallPolicy& policy) { policy_ = policy; }

private:
  Connection(Endpoint endpoint, std::shared_ptr<grpc::Channel> channel,
             std::shared_ptr<Interruption> interruption);
  /// Writes to standard error that a call is repeated, and why.
  void announce_retry(const grpc::Status& status, int attempts_made) const;

  /// Deadline of one attempt at a unary call.
  static constexpr std::chrono::seconds deadline{60};
  Endpoint endpoint_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<Stub> stub_;
  std::shared_ptr<Interruption> interruption_;
  CallPolicy policy_;
  std::function<void(Connection&)> restore_;
};

}  // namespace dccast::client
