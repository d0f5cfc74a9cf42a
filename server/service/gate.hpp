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
#include "server/access/token_uses.hpp"
#include "server/jobs/queue/tally.hpp"
#include "server/relay/peer_table.hpp"

namespace dccast::service {

/// Counts of calls since the daemon started. The duration of a stream ends when it is open.
struct CallFigures {
  /// Upper bounds of the histogram's buckets [s].
  static constexpr std::array<double, 6> bounds_s{0.001, 0.01, 0.1, 1.0, 10.0, 60.0};
  std::map<std::pair<std::string, std::string>, jobs::Histogram> seconds;  ///< by method and code
  std::map<std::string, std::uint64_t> refused;                            ///< by the limit
};

/// A stream, which ends when its caller loses access.
class LastingCall {
public:
  /// A stream may end while the gate still refers to it: the gate keeps weak references.
  virtual ~LastingCall() = default;
  /// Access was lost: the stream ends with `status`. Called from the gate's thread.
  virtual void lapse(const grpc::Status& status) = 0;
};

/// Credentials that a client presents with a call.
struct Credentials {
  std::shared_ptr<const relay::Peer> peer;  ///< other end of its connection
  std::string token{};
  /// The other end is dccast-web, which calls for the users of its tokens.
  bool is_web = false;
  std::string
      address{};  ///< of the client: that of the connection, or the one that dccast-web states

  /// Whether the connection itself proves a user of this machine.
  bool of_local_user() const { return !peer->over_tls && !is_web; }
};

/// Header in which dccast-web states the address of its client. It is believed from it alone.
inline constexpr const char* client_address_header = "dccast-client-address";

/// Name of a user of this machine, or the user id as text if the user has no name.
std::string user_name(unsigned id);
/// The user of this machine with a name; empty if there is none.
std::optional<unsigned> user_id(const std::string& name);

/// Cache of user_name(), which may ask a directory service: once for each user. Safe to use from
/// several threads.
class LocalUsers {
public:
  /// May block at the first call for a user.
  std::string name_of(unsigned id);

private:
  std::mutex mutex_;
  std::map<unsigned, std::string> names_;  ///< by user id
};

/// Finds the owner of a job, study or line; empty if there is none.
using OwnerOf = std::function<std::optional<std::string>(const std::string& id)>;

/// Authentication, permissions by role and by owner, limits on calls and streams, and the audit
/// log. Every call passes it. Safe to use from several threads.
class Gate {
public:
  /// Bounds on calls and streams.
  struct Limits {
    double calls_per_s = 1000.0;  ///< of one user
    std::size_t streams = 2000, streams_per_user = 1000;
  };
  /// How the gate finds the owner of what a call touches.
  struct Owners {
    OwnerOf job, study, line;
  };

  /// @param authority  users and roles
  /// @param audit  log of refusals and changes; both outlive this object
  /// @param web_user_id  user of dccast-web on this machine; empty: there is none
  Gate(access::Authority& authority, access::AuditLog& audit, const Limits& limits, Owners owners,
       std::optional<unsigned> web_user_id = {});

  /// Whether a connection is that of dccast-web.
  bool is_web(const relay::Peer& peer) const {
    return !peer.over_tls && peer.user_id && peer.user_id == web_user_id_;
  }
  std::optional<unsigned> web_user_id() const { return web_user_id_; }
  /// Determines the caller; may block to look up the name of a local user.
  access::Caller identify(const Credentials& credentials);
  /// Checks role and call rate.
  grpc::Status permit(const access::Caller& caller, const access::CallRule& rule,
                      const std::string& peer);
  /// Checks the owner of the job, study or line `id`; OK if there is none. One that the caller may
  /// not read either is refused as one that is not there. Reads the store.
  grpc::Status permit_touch(const access::Caller& caller, const access::CallRule& rule,
                            const std::string& id);

  /// Counts a stream, and ends the stream when its caller loses access. leave() removes it from the
  /// count. @throws refusal::LimitReached
  void enter(const access::Caller& caller, std::weak_ptr<LastingCall> stream);
  /// Takes a stream from the count.
  void leave(const access::Caller& caller) { streams_.leave(caller.name); }

  /// Completes an event with caller, call and outcome and appends it to the audit log.
  /// @param peer  address of the client
  void record(v1::AuditEvent event, const access::Caller& caller, const access::CallRule& rule,
              const std::string& peer, const grpc::Status& status);

  /// Counts a call that is answered. @param method  as in service.proto
  void count(const std::string& method, const grpc::Status& status,
             std::chrono::duration<double> taken);
  /// A copy of the figures so far.
  CallFigures figures();
  std::size_t open_streams() { return streams_.open(); }

  access::Authority& authority() { return authority_; }
  access::TokenUses& token_uses() { return token_uses_; }
  /// Peers of all open connections.
  relay::PeerTable& peers() { return peers_; }

private:
  /// The user of a connection to the Unix socket.
  access::Caller identify_local_user(const Credentials& credentials);
  /// The user of the token, whose use is noted.
  access::Caller identify_by_token(const Credentials& credentials);
  /// An open stream and whose access it depends on.
  struct Lasting {
    access::Caller caller;
    std::weak_ptr<LastingCall> stream;
  };
  /// The thread: ends the streams of users whose access is revoked, within a fraction of a second.
  void watch_for_lapses(const std::stop_token& stop);
  /// Ends the streams of callers without access. @param now  [s since 1970]
  void end_lapsed(std::int64_t now);

  access::Authority& authority_;
  access::AuditLog& audit_;
  LocalUsers local_users_;
  relay::PeerTable peers_;
  const Owners owners_;
  const std::optional<unsigned> web_user_id_;
  access::CallRate rate_, unproven_rate_, recorded_refusals_;
  access::TokenUses token_uses_;
  access::OpenCount streams_;
  std::mutex figures_mutex_;
  CallFigures figures_;
  std::mutex mutex_;  ///< guards lasting_
  std::vector<Lasting> lasting_;
  std::jthread watcher_;
};

}  // namespace dccast::service
