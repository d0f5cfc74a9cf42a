#pragma once

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <string>

#include "dccast/v1/access.pb.h"
#include "dccast/v1/job.pb.h"
#include "server/access/users.hpp"

namespace dccast::access {

/// A call of service.proto with what it requires.
struct CallRule {
  std::string name;  ///< "CancelJob"
  v1::CallAccess access;

  bool touches_job() const { return is_any_of({v1::READS_JOB, v1::CHANGES_JOB}); }
  bool touches_study() const { return is_any_of({v1::READS_STUDY, v1::CHANGES_STUDY}); }
  bool touches_line() const { return is_any_of({v1::READS_LINE, v1::CHANGES_LINE}); }
  bool changes() const { return is_any_of({v1::CHANGES_JOB, v1::CHANGES_STUDY, v1::CHANGES_LINE}); }

private:
  bool is_any_of(std::initializer_list<v1::Touches> kinds) const {
    return std::ranges::find(kinds, access.touches()) != kinds.end();
  }
};

/// The rule of a call, found by its request: no two calls share one. An unknown request requires an
/// admin.
const CallRule& rule_of(const google::protobuf::Descriptor& request);

/// Identifies callers and decides what they may do, from the list of users and the settings.
class Authority {
public:
  struct Policy {
    v1::Role local_role = v1::SUBMITTER;  ///< role of local users who are not listed
    std::string own_user{};               ///< user of the daemon, an admin like root
    bool reads_own_only = false;          ///< for callers without the role admin
  };

  Authority(UserStore& users, Policy policy) : users_(users), policy_(std::move(policy)) {}

  Caller local_user(const std::string& name);
  Caller by_token(const std::string& token, std::int64_t now) { return users_.prove(token, now); }
  /// @param name  the common name of a certificate whose chain was verified
  Caller by_certificate(const std::string& name, std::int64_t expires, std::int64_t now);

  /// Reason to end the access of a caller whose identity was proved; empty while nothing has
  /// changed. For calls that last.
  std::optional<refusal::Facts> lapse(const Caller& caller, std::int64_t now);

  /// Why the owner of a job may have it no more: disabled, or removed from the list; empty: the
  /// owner may.
  std::string refusal_of_owner(const v1::Job& job);

  /// Reason to deny a call because of the role; empty if allowed.
  std::optional<refusal::Facts> role_fault(const Caller& caller, const CallRule& rule);
  /// Whether only the owner of the job, study or line may make the call.
  bool needs_ownership(const Caller& caller, const CallRule& rule) const {
    return rule.access.touches() != v1::NOTHING && caller.role < v1::ADMIN &&
           (rule.changes() || policy_.reads_own_only);
  }
  /// Reason to deny access to a job, study or line of `owner`; empty if allowed.
  /// @param subject  "job", "study" or "line", with its id
  std::optional<refusal::Facts> owner_fault(const Caller& caller, const CallRule& rule,
                                            const std::string& owner, const std::string& subject);
  /// Whether lists, too, show only the caller's own jobs.
  bool reads_own_only(const Caller& caller) const {
    return policy_.reads_own_only && caller.role < v1::ADMIN;
  }

  UserStore& users() { return users_; }

private:
  std::string describe_admins();

  UserStore& users_;
  const Policy policy_;
};

}  // namespace dccast::access
