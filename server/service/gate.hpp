#pragma once

#include <grpcpp/support/status.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/access/audit.hpp"
#include "server/access/limits.hpp"
#include "server/access/rules.hpp"
#include "server/jobs/queue/tally.hpp"
#include "server/relay/peer_table.hpp"

namespace dccast::service {

/// Calls since the daemon began. Of one that lasts the time until it was open.
struct CallFigures {
  static constexpr std::array<double, 6> bounds_s{0.001, 0.01, 0.1, 1.0, 10.0, 60.0};
  std::map<std::pair<std::string, std::string>, jobs::Histogram> seconds;  ///< by method and code
  std::map<std::string, std::uint64_t> refused;                            ///< by the limit
};

/// A call that lasts: it is ended when its caller is one no longer.
class LastingCall {
public:
  virtual ~LastingCall() = default;
  virtual void lapse(const grpc::Status& status) = 0;
};

/// What a client has shown of itself with a call.
struct Shown {
  std::shared_ptr<const relay::Peer> peer;  ///< other end of its connection
  std::string token{};
};

/// The name of a user of this machine, or the number of one without a name.
std::string user_name(unsigned id);

/// As user_name(), which may ask a directory service, once for each user. Safe to use from several
/// threads.
class LocalUsers {
public:
  std::string name_of(unsigned id);

private:
  std::mutex mutex_;
  std::map<unsigned, std::string> names_;  ///< by user id
};

/// Who owns a job or study; nothing where there is none.
using OwnerOf = std::function<std::optional<std::string>(const std::string& id)>;

/// What every call passes: who calls, what the role permits, whose the job is, the limits on calls
/// and streams, and the audit log. Safe to use from several threads.
class Gate {
public:
  struct Limits {
    double calls_per_s = 1000.0;  ///< of one user
    std::size_t streams = 2000, streams_per_user = 1000;
  };
  struct Owners {
    OwnerOf job, study;
  };

  Gate(access::Authority& authority, access::AuditLog& audit, const Limits& limits, Owners owners);

  /// Looks the names of local users up, which may wait; others are judged at once.
  access::Caller identify(const Shown& shown);
  /// Role and rate.
  grpc::Status permit(const access::Caller& caller, const access::CallRule& rule,
                      const std::string& peer);
  /// Owner of the job or study with this id; OK where there is none. Reads the store.
  grpc::Status permit_touch(const access::Caller& caller, const access::CallRule& rule,
                            const std::string& id);

  /// Counts a stream, and ends it once its caller has lapsed; leave() undoes the first.
  /// @throws Refusal  a limit
  void enter(const access::Caller& caller, std::weak_ptr<LastingCall> stream);
  void leave(const access::Caller& caller) { streams_.leave(caller.name); }

  void record(v1::AuditEvent event, const access::Caller& caller, const access::CallRule& rule,
              const std::string& peer, const grpc::Status& status);

  /// Counts a call that is answered. @param method  as in service.proto
  void count(const std::string& method, const grpc::Status& status,
             std::chrono::duration<double> taken);
  CallFigures figures();
  std::size_t open_streams() { return streams_.open(); }

  access::Authority& authority() { return authority_; }
  /// Other ends of the connections that are open.
  relay::PeerTable& peers() { return peers_; }

private:
  struct Lasting {
    access::Caller caller;
    std::weak_ptr<LastingCall> stream;
  };
  void watch_for_lapses(const std::stop_token& stop);
  void end_lapsed(std::int64_t now);

  access::Authority& authority_;
  access::AuditLog& audit_;
  LocalUsers local_users_;
  relay::PeerTable peers_;
  const Owners owners_;
  access::CallRate rate_, unproven_rate_, recorded_refusals_;
  access::OpenCount streams_;
  std::mutex figures_mutex_;
  CallFigures figures_;
  std::mutex mutex_;  ///< of all below
  std::vector<Lasting> lasting_;
  std::jthread watcher_;
};

}  // namespace dccast::service
