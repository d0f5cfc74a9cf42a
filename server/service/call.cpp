#include "server/service/call.hpp"

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/auth_metadata_processor.h>
#include <grpcpp/server_context.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <stdexcept>
#include <utility>

#include "dccast/v1/service.pb.h"
#include "server/service/refusals.hpp"

namespace dccast::service {

namespace {

using Metadata = std::multimap<grpc::string_ref, grpc::string_ref>;

/// The last value of a header; empty if the call has no such header.
std::string header_in(const Metadata& metadata, const char* name) {
  const auto [first, end] = metadata.equal_range(name);
  if (first == end) return "";
  const grpc::string_ref value = std::prev(end)->second;
  return {value.data(), value.size()};
}

std::string token_in(const Metadata& metadata) {
  const std::string value = header_in(metadata, "authorization");
  constexpr std::string_view scheme = "Bearer ";
  return value.starts_with(scheme) ? value.substr(scheme.size()) : value;
}

/// What the client presents with a call: its connection and its token.
/// @throws std::runtime_error  the connection has ended
Credentials credentials_in(const Metadata& metadata, Gate& gate) {
  const auto peer = gate.peers().find(header_in(metadata, relay::connection_header));
  if (!peer) throw std::runtime_error("this call names no connection that is open");

  constexpr std::size_t longest_address = 100;
  const bool is_web = gate.is_web(*peer);
  const std::string stated =
      is_web ? header_in(metadata, client_address_header).substr(0, longest_address) : "";
  return {.peer = peer,
          .token = token_in(metadata),
          .is_web = is_web,
          .address = stated.empty() ? peer->address : stated};
}

/// Refuses calls without proof of identity once their headers have arrived, before the body is
/// read.
class ProofBeforeBody final : public grpc::AuthMetadataProcessor {
public:
  explicit ProofBeforeBody(Gate& gate) : gate_(gate) {}

  bool IsBlocking() const override { return false; }  // users are in memory

  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext*, OutputMetadata*,
                       OutputMetadata*) override try {
    const auto path = metadata.find(":path");
    const auto* method =
        path == metadata.end() ? nullptr : method_at({path->second.data(), path->second.size()});
    if (method == nullptr) return grpc::Status::OK;  // gRPC answers it, if only by UNIMPLEMENTED
    const access::CallRule& rule = access::rule_of(*method->input_type());
    if (rule.access.role() == v1::ANYONE) return grpc::Status::OK;

    const Credentials credentials = credentials_in(metadata, gate_);
    if (credentials.of_local_user())
      return grpc::Status::OK;  // admit() looks local users up: it may wait

    const access::Caller caller = gate_.identify(credentials);
    if (caller.proven()) {
      // The connections of dccast-web serve many users.
      if (!credentials.is_web)
        gate_.peers().set_user(header_in(metadata, relay::connection_header), caller.name);
      return grpc::Status::OK;
    }

    // The audit log records refusals that reach no handler, too.
    const grpc::Status status = gate_.permit(caller, rule, credentials.address);
    gate_.record({}, caller, rule, credentials.address, status);
    return status;
  } catch (const std::exception& error) {
    return make_status({.reason = ErrorInfo::BUSY, .cause = error.what()});
  }

private:
  Gate& gate_;
};

/// The `id` of the job, study or line that a request names; empty if its call touches none.
std::string id_of(const google::protobuf::Message& request, const access::CallRule& rule) {
  if (rule.access.touches() == v1::NOTHING) return "";
  const auto* field = request.GetDescriptor()->FindFieldByName("id");
  return field == nullptr ? "" : request.GetReflection()->GetString(request, field);
}

}  // namespace

const google::protobuf::MethodDescriptor* method_at(std::string_view path) {
  const auto* service =
      v1::SubmitJobRequest::descriptor()->file()->FindServiceByName("SimulationService");
  const std::string place = "/" + service->full_name() + "/";
  if (!path.starts_with(place)) return nullptr;
  return service->FindMethodByName(std::string(path.substr(place.size())));
}

std::shared_ptr<grpc::AuthMetadataProcessor> proof_before_body(Gate& gate) {
  return std::make_shared<ProofBeforeBody>(gate);
}

CallOrigin::CallOrigin(const grpc::CallbackServerContext& context, Gate& gate,
                       const google::protobuf::Message& request)
    : gate_(&gate),
      rule_(&access::rule_of(*request.GetDescriptor())),
      id_(id_of(request, *rule_)),
      deadline_(context.deadline()) {
  try {
    credentials_ = credentials_in(context.client_metadata(), gate);
    if (!credentials_.of_local_user()) judge();
  } catch (const std::exception& error) {
    refusal_ = make_status({.reason = ErrorInfo::BUSY, .cause = error.what()});
  }
}

void CallOrigin::judge() {
  caller_ = gate_->identify(credentials_);
  refusal_ = gate_->permit(*caller_, *rule_, credentials_.address);
  if (!refusal_.ok()) record_refusal(refusal_);
}

Call CallOrigin::admit(std::function<bool()> cancelled) {
  if (!caller_) judge();
  if (!refusal_.ok()) throw Refusal{refusal_};

  Call call{.caller = *caller_, .deadline = deadline_, .cancelled = std::move(cancelled)};
  check_wanted(call);

  if (const auto status = gate_->permit_touch(call.caller, *rule_, id_); !status.ok()) {
    record_refusal(status);
    throw Refusal{status};
  }
  return call;
}

void CallOrigin::check_id() const {
  if (rule_->touches_job()) check_job_id(id_);
  if (rule_->touches_study()) check_study_id(id_);
  if (rule_->touches_line()) check_line_name(id_);
}

void CallOrigin::count(const grpc::Status& status) const {
  gate_->count(rule_->name, status, std::chrono::steady_clock::now() - begun_);
}

void CallOrigin::record(const Call& call, const grpc::Status& status) const {
  count(status);

  v1::AuditEvent event = *call.note;
  if (rule_->touches_job()) event.set_job(id_);
  if (rule_->touches_study()) event.set_study(id_);
  if (rule_->touches_line()) event.set_line(id_);
  gate_->record(std::move(event), call.caller, *rule_, credentials_.address, status);
}

void CallOrigin::record_refusal(const grpc::Status& status) const {
  record({.caller = *caller_}, status);
}

void check_wanted(const Call& call) {
  if (call.cancelled()) refuse(ErrorInfo::CALLER_LEFT, "the caller has left");
  if (std::chrono::system_clock::now() >= call.deadline)
    refuse(ErrorInfo::TOO_LATE, Remedy{"try again"}, "the call waited until its deadline");
}

jobs::CallLimits waiting_time(const Call& call, double most_s) {
  using std::chrono::nanoseconds;
  const auto most = std::chrono::duration_cast<nanoseconds>(std::chrono::duration<double>(most_s));

  const nanoseconds left = call.deadline - std::chrono::system_clock::now();

  return {.deadline = std::chrono::steady_clock::now() + std::min(left, most),
          .called_off = call.cancelled};
}

}  // namespace dccast::service
