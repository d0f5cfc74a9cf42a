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

/// Who calls and how long they wait.
struct Call {
  access::Caller caller;
  std::chrono::system_clock::time_point deadline = std::chrono::system_clock::time_point::max();
  std::function<bool()> cancelled = [] { return false; };
  /// What the audit log is to have of it besides: what a handler finds or makes.
  std::shared_ptr<v1::AuditEvent> note = std::make_shared<v1::AuditEvent>();
};

/// What is kept of a call for its turn in a lane, when its context may be gone already. There is
/// no other way to a Call, and so none past the gate.
class CallOrigin {
public:
  /// Over TLS the caller is judged here, before anything is kept of the call; a local user, whom it
  /// takes a moment to find, in admit().
  /// @param gate  outlives this object
  CallOrigin(const grpc::CallbackServerContext& context, Gate& gate,
             const google::protobuf::Message& request);

  /// Not OK: the call is refused, and recorded.
  const grpc::Status& refusal() const { return refusal_; }
  /// For a thread that may wait, of a call that is not cancelled: that costs an exception, and a
  /// peer may cancel ten thousand calls a second. @throws Refusal  why it is not answered, which is
  /// recorded
  Call admit(std::function<bool()> cancelled);
  /// Of the job or study that the request names. @throws Refusal
  void check_id() const;
  /// For the audit log and the figures of the gate.
  void record(const Call& call, const grpc::Status& status) const;
  /// For the figures alone: of a call that was not admitted.
  void count(const grpc::Status& status) const;
  Gate& gate() const { return *gate_; }

private:
  void judge();
  void record_refusal(const grpc::Status& status) const;

  Gate* gate_;
  const access::CallRule* rule_;
  std::string id_;  ///< of the job or study that the request names
  Shown shown_;
  std::chrono::system_clock::time_point deadline_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::optional<access::Caller> caller_;  ///< once it was judged
  grpc::Status refusal_;
};

/// The call of ours at a path ("/dccast.v1.SimulationService/GetJob"); null: none.
const google::protobuf::MethodDescriptor* method_at(std::string_view path);

/// Refuses a call over TLS that needs a proof of who the caller is, and has none, when its headers
/// have come, before its request is read.
/// @param gate  outlives it
std::shared_ptr<grpc::AuthMetadataProcessor> proof_before_body(Gate& gate);

/// @throws Refusal  the call is cancelled or past its deadline
void check_wanted(const Call& call);

/// As long as the caller waits, and no longer than so many seconds.
jobs::CallLimits waiting_time(const Call& call, double most_s);

}  // namespace dccast::service
