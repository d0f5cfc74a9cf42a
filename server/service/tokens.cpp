// Calls about the caller: signing in, and tokens.
#include <fmt/format.h>

#include <cmath>
#include <ctime>

#include "proto/values/printable.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

namespace {

/// A line that its user asked for is used at once; what is forgotten in a mail is worth nothing.
constexpr std::int64_t sign_in_lifetime_s = 600;

void describe(const access::Caller& caller, v1::WhoAmIResponse& response) {
  response.set_name(caller.name);
  response.set_role(caller.role);
  response.set_proof(access::text_of(caller.by));
  if (caller.expires_unix != 0) response.mutable_expire_time()->set_seconds(caller.expires_unix);
}

/// "192.0.2.7" of "ipv4:192.0.2.7:40000", "2001:db8::7" of "ipv6:%5B2001:db8::7%5D:0"; "unix" of a
/// user of this machine.
std::string host_of(const std::string& address) {
  const auto kind = address.find(':');
  std::string host = address.substr(kind + 1, address.rfind(':') - kind - 1);
  if (host.empty()) return address.substr(0, kind);

  constexpr std::string_view begin = "%5B", end = "%5D";
  if (host.starts_with(begin) && host.ends_with(end))
    host = host.substr(begin.size(), host.size() - begin.size() - end.size());
  return host;
}

void describe(const v1::Credential& credential, const std::optional<access::TokenUse>& use,
              v1::Token& token) {
  token.set_id(credential.id());
  token.set_name(credential.machine());
  token.set_is_secret(credential.enrolment());
  token.mutable_create_time()->set_seconds(credential.created_unix());
  token.mutable_expire_time()->set_seconds(credential.expires_unix());
  if (!use) return;
  token.mutable_last_use_time()->set_seconds(use->unix_s);
  token.set_last_use_address(host_of(use->address));
}

}  // namespace

Unary* SimulationService::Enrol(Wire* wire, const v1::EnrolRequest* request,
                                v1::EnrolResponse* response) {
  return answer(wire, *request, pools_.durable, [=, this](const Call& call) {
    check_text("machine", request->machine());

    const std::int64_t now = std::time(nullptr);
    const access::Caller user = context_.gate.authority().users().enrol(
        request->secret(), request->machine(), now,
        now + std::llround(context_.settings.access().token_lifetime_s()),
        *response->mutable_token());

    if (!user.proven()) throw Refusal{make_status(*user.refusal)};
    call.note->set_user(user.name);
    call.note->set_reason("a token was made for " + request->machine());
    describe(user, *response->mutable_user());
  });
}

Unary* SimulationService::WhoAmI(Wire* wire, const v1::WhoAmIRequest* request,
                                 v1::WhoAmIResponse* response) {
  return answer(wire, *request, pools_.status,
                [=](const Call& call) { describe(call.caller, *response); });
}

Unary* SimulationService::IssueSignIn(Wire* wire, const v1::IssueSignInRequest* request,
                                      v1::IssueSignInResponse* response) {
  return answer(wire, *request, pools_.durable, [=, this](const Call& call) {
    access::UserStore& users = context_.gate.authority().users();
    const std::string& name = call.caller.name;
    if (!users.find(name))
      refuse(ErrorInfo::WRONG_STATE,
             Remedy{fmt::format("an admin can change that: dccastd user add {} --role submitter",
                                name.empty() ? "NAME" : name)},
             "{} is not in the list of users, and signs in nowhere else",
             name.empty() ? "this local user" : name);

    const std::int64_t now = std::time(nullptr), ends = now + sign_in_lifetime_s;
    response->set_secret(users.add_line(name, "", now, ends));
    const std::string& web = context_.settings.access().web_address();
    if (!web.empty()) response->set_link(access::sign_in_link(web, response->secret()));
    response->mutable_expire_time()->set_seconds(ends);
    call.note->set_reason("a secret was made to sign in once more");
  });
}

Unary* SimulationService::ListTokens(Wire* wire, const v1::ListTokensRequest* request,
                                     v1::ListTokensResponse* response) {
  return answer(wire, *request, pools_.status, [=, this](const Call& call) {
    const auto user = context_.gate.authority().users().find(call.caller.name);
    if (!user) return;

    const std::int64_t now = std::time(nullptr);
    for (const v1::Credential& credential : user->credential()) {
      if (credential.expires_unix() <= now) continue;
      v1::Token& token = *response->add_tokens();
      describe(credential, context_.gate.token_uses().last(credential.id()), token);
      token.set_is_of_this_call(credential.id() == call.caller.credential);
    }
  });
}

Unary* SimulationService::RevokeToken(Wire* wire, const v1::RevokeTokenRequest* request,
                                      v1::RevokeTokenResponse*) {
  return answer(wire, *request, pools_.durable, [=, this](const Call& call) {
    const std::string& id = request->id().empty() ? call.caller.credential : request->id();
    if (id.empty())
      refuse(ErrorInfo::WRONG_STATE,
             "this call was not made with a token; there is nothing to revoke");

    access::UserStore& users = context_.gate.authority().users();
    if (!users.find(call.caller.name) || !users.revoke(call.caller.name, id))
      refuse(ErrorInfo::NOT_FOUND, Remedy{"the list of tokens names those there are"},
             "{} has no token {}", call.caller.name, values::shown(id));
    call.note->set_reason(fmt::format("the token {} was revoked by its user", id));
  });
}

}  // namespace dccast::service
