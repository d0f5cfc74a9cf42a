#pragma once

#include <google/protobuf/descriptor.h>

#include <cstdint>
#include <string>

#include "dccast/v1/access.pb.h"
#include "server/access/users.hpp"

namespace dccast::access {

/// A call of service.proto with what it requires.
struct CallRule {
  std::string name;  ///< "CancelJob"
  v1::CallAccess access;

  bool touches_job() const { return is_any_of(v1::READS_JOB, v1::CHANGES_JOB); }
  bool touches_study() const { return is_any_of(v1::READS_STUDY, v1::CHANGES_STUDY); }
  bool changes() const { return is_any_of(v1::CHANGES_JOB, v1::CHANGES_STUDY); }

private:
  bool is_any_of(v1::Touches one, v1::Touches other) const {
    return access.touches() == one || access.touches() == other;
  }
};

/// The rule of the call whose request this is: no two calls have the same. A request that no call
/// has requires an admin.
const CallRule& rule_of(const google::protobuf::Descriptor& request);

/// Who callers are and what they may do, by the list of users and the settings.
class Authority {
public:
  struct Policy {
    v1::Role local_role = v1::SUBMITTER;  ///< of local users who are not listed
    std::string own_user{};               ///< of the daemon: admin like root
    bool reads_own_only = false;          ///< of callers without the role admin
  };

  Authority(UserStore& users, Policy policy) : users_(users), policy_(std::move(policy)) {}

  Caller local_user(const std::string& name);
  Caller by_token(const std::string& token, std::int64_t now) { return users_.prove(token, now); }
  /// @param name  the common name of a certificate whose chain was verified
  Caller by_certificate(const std::string& name, std::int64_t expires, std::int64_t now);

  /// Why a caller who was proved is one no longer; empty while nothing has changed. For calls that
  /// last.
  std::string lapse(const Caller& caller, std::int64_t now);

  /// Why the role does not permit the call; empty where it does.
  std::string role_fault(const Caller& caller, const CallRule& rule);
  /// Whether the call is for the owner of its job or study alone.
  bool needs_ownership(const Caller& caller, const CallRule& rule) const {
    return rule.access.touches() != v1::NOTHING && caller.role < v1::ADMIN &&
           (rule.changes() || policy_.reads_own_only);
  }
  /// Why a job or study of `owner` is not to be touched so; empty where it is.
  /// @param what  "job" or "study", with its id
  std::string owner_fault(const Caller& caller, const CallRule& rule, const std::string& owner,
                          const std::string& what);
  /// Whether lists, too, are of the caller's own alone.
  bool reads_own_only(const Caller& caller) const {
    return policy_.reads_own_only && caller.role < v1::ADMIN;
  }

  UserStore& users() { return users_; }

private:
  std::string whom_to_ask();

  UserStore& users_;
  const Policy policy_;
};

}  // namespace dccast::access
