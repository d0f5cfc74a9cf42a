// Calls about the caller itself.
#include "server/service/request_checks.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

namespace {

void describe(const access::Caller& caller, v1::WhoAmIResponse& response) {
  response.set_name(caller.name);
  response.set_role(caller.role);
  response.set_proof(access::text_of(caller.by));
  response.set_expires_unix(caller.expires_unix);
}

}  // namespace

using Unary = SimulationService::Unary;

Unary* SimulationService::Enrol(Wire* wire, const v1::EnrolRequest* request,
                                v1::EnrolResponse* response) {
  const auto work = [=, this](const Call& call) {
    if (const auto status = check_text("machine", request->machine()); !status.ok()) return status;
    const std::int64_t now = unix_now();
    access::UserStore& users = context_.gate.authority().users();
    const access::Proof proof =
        users.enrol(request->secret(), request->machine(), now, now + context_.token_lifetime_s,
                    *response->mutable_token());
    if (!proof.proven) return grpc::Status(grpc::StatusCode::UNAUTHENTICATED, proof.refusal);
    call.note->set_user(proof.proven->name);
    call.note->set_reason("a token was made for " + request->machine());
    describe({.name = proof.proven->name,
              .role = proof.proven->role,
              .by = access::ProvenBy::token,
              .expires_unix = proof.proven->expires_unix},
             *response->mutable_user());
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.durable, work}});
}

Unary* SimulationService::WhoAmI(Wire* wire, const v1::WhoAmIRequest* request,
                                 v1::WhoAmIResponse* response) {
  const auto work = [=](const Call& call) {
    describe(call.caller, *response);
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.status, work}});
}

Unary* SimulationService::RevokeToken(Wire* wire, const v1::RevokeTokenRequest* request,
                                      v1::RevokeTokenResponse*) {
  const auto work = [this](const Call& call) {
    if (call.caller.credential.empty())
      return grpc::Status(grpc::StatusCode::FAILED_PRECONDITION,
                          "this call was not made with a token; there is nothing to revoke");
    context_.gate.authority().users().revoke(call.caller.name, call.caller.credential);
    call.note->set_reason("the token was revoked by its user");
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.durable, work}});
}

}  // namespace dccast::service
