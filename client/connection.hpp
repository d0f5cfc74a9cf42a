#pragma once

#include <chrono>
#include <memory>
#include <string>

#include <grpcpp/client_context.h>

#include "client/failure.hpp"
#include "client/interruption.hpp"
#include "dccast/v1/service.grpc.pb.h"

namespace dccast::client {

using Stub = v1::SimulationService::StubInterface;

/// How often a call that may be repeated is made, and how long the pauses between are.
struct CallPolicy {
  int attempts = 4;
  std::chrono::milliseconds first_pause{200};  ///< doubled after every attempt
};

/// A daemon to talk to. The connection is made by the first call, and never through a proxy: the
/// address is that of the daemon itself, whatever http_proxy says.
class Connection {
public:
  explicit Connection(const std::string& server, std::shared_ptr<Interruption> interruption =
                                                     std::make_shared<Interruption>());

  Stub& stub() { return *stub_; }
  const std::string& server() const { return server_; }
  /// Whoever waits for this server, in a call or between two, must listen to it.
  Interruption& interruption() { return *interruption_; }

  /// One unary call that may be repeated (see try_call). Throws CommandFailed for any status but
  /// OK.
  template <typename Request, typename Response>
  Response call(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                const Request& request) {
    Response response;
    check(try_call(method, request, response), server_);
    return response;
  }

  /// The same for a call that must not be repeated, because the second answer would differ from
  /// the first: a job resumed or deleted twice.
  template <typename Request, typename Response>
  Response call_once(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                     const Request& request) {
    Response response;
    check(attempt(method, request, response), server_);
    return response;
  }

  /// One attempt at a call. @return its status. Throws Interrupted.
  template <typename Request, typename Response>
  grpc::Status try_once(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                     Response*),
                        const Request& request, Response& response) {
    return attempt(method, request, response);
  }

  /// A unary call with a deadline, made again with longer and longer pauses while the server is
  /// UNAVAILABLE, which is said on standard error. For calls that may come twice: all that only
  /// read, SubmitJob with its request id, CancelJob. @return the status of the last attempt.
  /// Throws Interrupted.
  template <typename Request, typename Response>
  grpc::Status try_call(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                     Response*),
                        const Request& request, Response& response) {
    auto pause = policy_.first_pause;
    for (int made = 1;; ++made, pause *= 2) {
      const grpc::Status status = attempt(method, request, response);
      if (status.error_code() != grpc::StatusCode::UNAVAILABLE || made >= policy_.attempts)
        return status;
      announce_retry(status, made);
      interruption_->sleep(pause);
    }
  }

  void set_policy(const CallPolicy& policy) { policy_ = policy; }

private:
  template <typename Request, typename Response>
  grpc::Status attempt(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                    Response*),
                       const Request& request, Response& response) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + deadline);
    const Interruption::Call call(*interruption_, context);
    const grpc::Status status = (stub_.get()->*method)(&context, request, &response);
    if (!status.ok() && interruption_->came()) throw Interrupted("");
    return status;
  }
  void announce_retry(const grpc::Status& status, int attempts_made) const;

  static constexpr std::chrono::seconds deadline{60};  // also for a case with large attachments
  std::string server_;
  std::unique_ptr<Stub> stub_;
  std::shared_ptr<Interruption> interruption_;
  CallPolicy policy_;
};

}  // namespace dccast::client
