#include "server/access/rules.hpp"

#include <map>

#include "dccast/v1/service.pb.h"

namespace dccast::access {

namespace {

using Rules = std::map<const google::protobuf::Descriptor*, CallRule>;

Rules read_rules() {
  Rules rules;
  rules[nullptr].access.set_role(v1::ADMIN);  // of a request that no call has
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

std::string named(const Caller& caller) {
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
    if (listed->disabled()) caller.refusal = disabled_text(name);
  }
  return caller;
}

Caller Authority::by_certificate(const std::string& name, std::int64_t expires, std::int64_t now) {
  Caller caller{.by = ProvenBy::certificate, .expires_unix = expires};
  const auto listed = users_.find(name);
  if (!listed) {
    caller.refusal = "the certificate is of \"" + name +
                     "\", who is not listed here; an admin can change that: dccastd user add " +
                     name + " --role submitter";
    return caller;
  }
  caller.name = name;
  caller.role = listed->role();
  caller.refusal = lapse(caller, now);
  return caller;
}

std::string Authority::lapse(const Caller& caller, std::int64_t now) {
  if (caller.expires_unix != 0 && caller.expires_unix <= now)
    return "the " + text_of(caller.by) + " of " + caller.name + " has expired; " +
           (caller.by == ProvenBy::token ? "ask an admin for a new line (dccastd user rotate " +
                                               caller.name + ") and log in again"
                                         : "ask who issued it for a new one");
  const auto listed = users_.find(caller.name);
  if (!listed)
    return caller.by == ProvenBy::local_user
               ? ""
               : "user " + caller.name + " was removed; ask an admin (dccastd user add)";
  const bool owns_daemon = caller.by == ProvenBy::local_user && caller.role >= v1::ADMIN;
  if (listed->disabled() && !owns_daemon) return disabled_text(caller.name);
  if (caller.by != ProvenBy::token) return "";
  for (const v1::Credential& one : listed->credential())
    if (one.id() == caller.credential) return "";
  return "the token of " + caller.name + " was revoked; ask an admin for a new line (dccastd " +
         "user rotate " + caller.name + ") and log in again";
}

std::string Authority::whom_to_ask() {
  std::string admins;
  const v1::Users all = users_.users();
  for (const v1::User& user : all.user())
    if (user.role() == v1::ADMIN && !user.disabled()) admins += ", " + user.name();
  const std::string own = policy_.own_user == "root" ? "" : " or " + policy_.own_user;
  return "ask an admin: root" + own + " on the server's machine" + admins;
}

std::string Authority::role_fault(const Caller& caller, const CallRule& rule) {
  if (caller.role >= rule.access.role()) return "";
  return named(caller) + " has the role " + text_of(caller.role) + ", and " + rule.name +
         " needs " + text_of(rule.access.role()) + "; " + whom_to_ask() +
         " (dccastd user role NAME ROLE)";
}

std::string Authority::owner_fault(const Caller& caller, const CallRule& rule,
                                   const std::string& owner, const std::string& what) {
  if (!needs_ownership(caller, rule) || (!caller.name.empty() && caller.name == owner)) return "";
  const std::string whose = owner.empty() ? "of no known user" : "of " + owner;
  return what + " is " + whose + ", and " + named(caller) + " (" + text_of(caller.role) + ") may " +
         (rule.changes() ? "change" : "read") + " only jobs and studies of their own; ask " +
         (owner.empty() ? "" : owner + ", or ") + whom_to_ask().substr(4);
}

}  // namespace dccast::access
