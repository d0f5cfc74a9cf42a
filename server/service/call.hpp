#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/jobs/executors/worker_process.hpp"
#include "server/service/gate.hpp"

namespace grpc {
class AuthMetadataProcessor;
class CallbackServerContext;
}  // namespace grpc

namespace dccast::service {

/// Caller, deadline and cancellation of an admitted call.
struct Call {
  /// Who calls, until when the answer is wanted, and whether it still is.
  access::Caller caller;
  std::chrono::system_clock::time_point deadline = std::chrono::system_clock::time_point::max();
  std::function<bool()> cancelled = [] { return false; };
  /// Entry of the audit log, to which a handler adds what it found or made.
  std::shared_ptr<v1::AuditEvent> note = std::make_shared<v1::AuditEvent>();
};

/// What a call keeps for its turn in a pool, when its gRPC context may no longer exist. A Call is
/// made only by admit(), so that no handler runs before the gate has permitted it.
class CallOrigin {
public:
  /// Judges callers over TLS at once, before memory is spent on the call. Local users are judged in
  /// admit(), because finding their name may block.
  /// @param gate  outlives this object
  CallOrigin(const grpc::CallbackServerContext& context, Gate& gate,
             const google::protobuf::Message& request);

  /// If not OK, the call is refused and the refusal recorded.
  const grpc::Status& refusal() const { return refusal_; }
  /// Admits a call that is not cancelled; may block. Check for cancellation first: a refusal costs
  /// an exception, and a peer may cancel ten thousand calls a second.
  /// @throws Refusal  reason why the call is not answered; it has been recorded
  Call admit(std::function<bool()> cancelled);
  /// Checks the form of the id of a job or study. @throws Refusal  INVALID_ARGUMENT
  void check_id() const;
  /// Records an admitted call in the audit log and in the gate's figures.
  void record(const Call& call, const grpc::Status& status) const;
  /// Records a call that was not admitted, in the gate's figures only.
  void count(const grpc::Status& status) const;
  /// Gate by which the call was judged.
  Gate& gate() const { return *gate_; }

private:
  /// Judges a caller over TLS: proof of identity, role and call rate.
  void judge();
  /// Writes a refusal into the audit log and the figures.
  void record_refusal(const grpc::Status& status) const;

  /// Never null; a pointer so that an origin can be moved.
  Gate* gate_;
  /// Role that the method needs, and whether it touches a job, study or line.
  const access::CallRule* rule_;
  std::string id_;  ///< of the job or study named in the request
  Credentials credentials_;
  std::chrono::system_clock::time_point deadline_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::optional<access::Caller> caller_;  ///< set when judged
  grpc::Status refusal_;
};

/// Method of our service at a path ("/dccast.v1.SimulationService/GetJob"); null for other paths.
const google::protobuf::MethodDescriptor* method_at(std::string_view path);

/// Processor that refuses a call over TLS without the proof of identity it needs, when its headers
/// have arrived and before its request is read.
/// @param gate  outlives the processor
std::shared_ptr<grpc::AuthMetadataProcessor> proof_before_body(Gate& gate);

/// @throws Refusal  the call is cancelled or past its deadline
void check_wanted(const Call& call);

/// Limits by the caller's deadline and by a longest time [s], whichever is shorter.
jobs::CallLimits waiting_time(const Call& call, double most_s);

}  // namespace dccast::service
