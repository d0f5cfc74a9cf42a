#include "server/access/rules.hpp"

#include <fmt/core.h>

#include <map>

#include "dccast/v1/service.pb.h"

namespace dccast::access {

namespace {

using Rules = std::map<const google::protobuf::Descriptor*, CallRule>;

Rules read_rules() {
  Rules rules;
  rules[nullptr].access.set_role(v1::ADMIN);  // for unknown requests
  const auto* service =
      v1::SubmitJobRequest::descriptor()->file()->FindServiceByName("SimulationService");
  for (int i = 0; i < service->method_count(); ++i) {
    const auto* method = service->method(i);
    CallRule& rule = rules[method->input_type()];
    rule = {method->name(), method->options().GetExtension(v1::access)};
    if (rule.access.role() == v1::ROLE_UNSPECIFIED) rule.access.set_role(v1::ADMIN);
  }
  return rules;
}

refusal::Facts removed(const std::string& name) {
  return not_proven(fmt::format("user {} was removed", name), "ask an admin (dccastd user add)");
}

std::string display_name(const Caller& caller) {
  return caller.name.empty() ? "a local user whom the system cannot name" : caller.name;
}

}  // namespace

const CallRule& rule_of(const google::protobuf::Descriptor& request) {
  static const Rules rules = read_rules();
  const auto found = rules.find(&request);
  return found == rules.end() ? rules.at(nullptr) : found->second;
}

Caller Authority::local_user(const std::string& name) {
  Caller caller{.name = name, .role = policy_.local_role};
  if (name.empty()) return caller;
  if (name == "root" || name == policy_.own_user) {
    caller.role = v1::ADMIN;
  } else if (const auto listed = users_.find(name)) {
    caller.role = listed->role();
    if (listed->disabled()) caller.refusal = disabled(name);
  }
  return caller;
}

Caller Authority::by_certificate(const std::string& name, std::int64_t expires, std::int64_t now) {
  Caller caller{.by = ProvenBy::certificate, .expires_unix = expires};
  const auto listed = users_.find(name);
  if (!listed) {
    caller.refusal = not_proven(
        fmt::format("the certificate is of \"{}\", who is not listed here", name),
        fmt::format("an admin can change that: dccastd user add {} --role submitter", name));
    return caller;
  }

  caller.name = name;
  caller.role = listed->role();
  caller.refusal = lapse(caller, now);
  return caller;
}

std::optional<refusal::Facts> Authority::lapse(const Caller& caller, std::int64_t now) {
  const std::string new_line = fmt::format(
      "ask an admin for a new line (dccastd user rotate {}) and log in again", caller.name);
  const bool is_local = caller.by == ProvenBy::local_user;

  if (caller.expires_unix != 0 && caller.expires_unix <= now)
    return not_proven(fmt::format("the {} of {} has expired", text_of(caller.by), caller.name),
                      caller.by == ProvenBy::token ? new_line : "ask who issued it for a new one");

  const auto listed = users_.find(caller.name);
  if (!listed && is_local) return std::nullopt;  // local users need not be listed
  if (!listed) return removed(caller.name);

  const bool owns_daemon = is_local && caller.role >= v1::ADMIN;
  if (listed->disabled() && !owns_daemon) return disabled(caller.name);

  if (caller.by != ProvenBy::token) return std::nullopt;
  for (const v1::Credential& credential : listed->credential())
    if (credential.id() == caller.credential) return std::nullopt;
  return not_proven(fmt::format("the token of {} was revoked", caller.name), new_line);
}

std::string Authority::refusal_of_owner(const v1::Job& job) {
  const auto listed = users_.find(job.owner());
  if (!listed) return job.owner_is_listed() ? removed(job.owner()).cause : std::string();
  return listed->disabled() ? disabled(job.owner()).cause : std::string();
}

std::string Authority::describe_admins() {
  std::string listed;
  const v1::Users users = users_.users();
  for (const v1::User& user : users.user())
    if (user.role() == v1::ADMIN && !user.disabled()) listed += fmt::format(", {}", user.name());

  std::string local = "root";
  if (policy_.own_user != "root") local += fmt::format(" or {}", policy_.own_user);
  return fmt::format("{} on the server's machine{}", local, listed);
}

std::optional<refusal::Facts> Authority::role_fault(const Caller& caller, const CallRule& rule) {
  if (caller.role >= rule.access.role()) return std::nullopt;
  return refusal::Facts{
      .reason = v1::ErrorInfo::NOT_PERMITTED,
      .cause = fmt::format("{} has the role {}, and {} needs {}", display_name(caller),
                           text_of(caller.role), rule.name, text_of(rule.access.role())),
      .remedy = fmt::format("ask an admin: {} (dccastd user role NAME ROLE)", describe_admins())};
}

std::optional<refusal::Facts> Authority::owner_fault(const Caller& caller, const CallRule& rule,
                                                     const std::string& owner,
                                                     const std::string& subject) {
  const bool is_owner = !caller.name.empty() && caller.name == owner;
  if (!needs_ownership(caller, rule) || is_owner) return std::nullopt;

  return refusal::Facts{
      .reason = v1::ErrorInfo::NOT_PERMITTED,
      .cause =
          fmt::format("{} is of {}, and {} ({}) may {} only jobs, studies and lines of their own",
                      subject, owner.empty() ? "no known user" : owner, display_name(caller),
                      text_of(caller.role), rule.changes() ? "change" : "read"),
      .remedy = fmt::format("ask {}an admin: {}",
                            owner.empty() ? "" : fmt::format("{}, or ", owner), describe_admins())};
}

}  // namespace dccast::access
