#include "server/service/gate.hpp"

#include <absl/status/status.h>

#include <condition_variable>
#include <ctime>
#include <exception>

#include "server/jobs/log.hpp"
#include "server/service/refusals.hpp"

namespace dccast::service {

namespace {

constexpr std::chrono::milliseconds between_looks{200};
// Calls that change nothing cost their caller little, so refusals must not fill the disk. The rate
// applies to each user, and to all unauthenticated callers together.
constexpr double recorded_refusals_per_s = 10.0;

std::string name_of(grpc::StatusCode code) {
  return absl::StatusCodeToString(static_cast<absl::StatusCode>(code));
}

/// The address without its port, so that connections of one machine share a limit.
std::string host_of(const std::string& peer) {
  return peer.substr(0, peer.rfind(':'));
}

}  // namespace

Gate::Gate(access::Authority& authority, access::AuditLog& audit, const Limits& limits,
           Owners owners, std::optional<unsigned> web_user_id)
    : authority_(authority),
      audit_(audit),
      owners_(std::move(owners)),
      web_user_id_(web_user_id),
      rate_(limits.calls_per_s),
      unproven_rate_(limits.calls_per_s / 10.0),
      recorded_refusals_(recorded_refusals_per_s),
      streams_(limits.streams, limits.streams_per_user),
      watcher_([this](const std::stop_token& stop) { watch_for_lapses(stop); }) {}

access::Caller Gate::identify(const Credentials& credentials) {
  const relay::Peer& peer = *credentials.peer;
  if (credentials.of_local_user()) return identify_local_user(credentials);
  if (!credentials.token.empty()) return identify_by_token(credentials);
  if (!peer.certificate_name.empty())
    return authority_.by_certificate(peer.certificate_name, peer.certificate_ends_unix,
                                     std::time(nullptr));
  return {
      .by = access::ProvenBy::token,
      .refusal = access::not_proven(
          "this call has no token",
          credentials.is_web ? "sign in on the pages of dccast-web with a line of `dccastd user "
                               "line`, or send a token as Authorization: Bearer TOKEN"
                             : "log in first: dccast login, with the line of `dccastd user add`")};
}

/// The socket proves the user. A token beside it must be of the same one: a call does not run as
/// another user than its token says.
access::Caller Gate::identify_local_user(const Credentials& credentials) {
  const auto& user_id = credentials.peer->user_id;
  access::Caller local = authority_.local_user(user_id ? local_users_.name_of(*user_id) : "");
  if (credentials.token.empty()) return local;

  const access::Caller named = identify_by_token(credentials);
  if (!named.proven()) return named;
  if (named.name != local.name)
    local.refusal = access::not_proven(
        fmt::format("the token of this call is of {}, and the socket is of {}", named.name,
                    local.name.empty() ? "no known user" : local.name),
        "leave the token out, or call over TLS");
  return local;
}

access::Caller Gate::identify_by_token(const Credentials& credentials) {
  const std::int64_t now = std::time(nullptr);
  access::Caller caller = authority_.by_token(credentials.token, now);
  if (caller.proven()) token_uses_.note(caller.credential, {now, credentials.address});
  return caller;
}

grpc::Status Gate::permit(const access::Caller& caller, const access::CallRule& rule,
                          const std::string& peer) {
  const bool proven = caller.proven();
  const std::string user = proven && !caller.name.empty() ? caller.name : host_of(peer);
  access::CallRate& rate = proven ? rate_ : unproven_rate_;

  // The rate is checked first: calls of unauthenticated peers must stay cheap.
  if (!rate.take(user, std::chrono::steady_clock::now()))
    return make_status(
        {.reason = ErrorInfo::LIMIT_REACHED,
         .cause = fmt::format("{} makes more calls a second than {} may", user,
                              proven ? "one user" : "one who has proved nothing (a tenth)"),
         .limit = "per_user.maximum_calls_per_s",
         .permitted = fmt::format("{:f}", rate_.per_s()),
         .remedy = "wait a moment, then try again"});

  if (rule.access.role() == v1::ANYONE) return grpc::Status::OK;
  if (!proven) return make_status(*caller.refusal);
  if (const auto fault = authority_.role_fault(caller, rule)) return make_status(*fault);
  return grpc::Status::OK;
}

grpc::Status Gate::permit_touch(const access::Caller& caller, const access::CallRule& rule,
                                const std::string& id) {
  if (!authority_.needs_ownership(caller, rule)) return grpc::Status::OK;
  struct Kind {
    const char* name;
    const OwnerOf& owner_of;
    grpc::Status (*unknown)(const std::string& id);
  };
  const Kind kind = rule.touches_line()    ? Kind{"line", owners_.line, &unknown_line}
                    : rule.touches_study() ? Kind{"study", owners_.study, &unknown_study}
                                           : Kind{"job", owners_.job, &unknown_job};

  const auto owner = kind.owner_of(id);
  if (!owner) return grpc::Status::OK;  // the handler answers NOT_FOUND
  const auto fault =
      authority_.owner_fault(caller, rule, *owner, fmt::format("{} {}", kind.name, id));
  if (!fault) return grpc::Status::OK;
  return authority_.reads_own_only(caller) ? kind.unknown(id) : make_status(*fault);
}

void Gate::enter(const access::Caller& caller, std::weak_ptr<LastingCall> stream) {
  streams_.enter(caller.name, "streams");

  const std::lock_guard lock(mutex_);
  std::erase_if(lasting_, [](const Lasting& call) { return call.stream.expired(); });
  lasting_.push_back({caller, std::move(stream)});
}

/// A check costs one stat of the users file: five a second end the streams of a revoked user
/// without noticeable delay.
void Gate::watch_for_lapses(const std::stop_token& stop) {
  std::condition_variable_any ended;
  std::unique_lock lock(mutex_);
  while (!ended.wait_for(lock, stop, between_looks, [&] { return stop.stop_requested(); })) {
    if (lasting_.empty()) continue;

    lock.unlock();
    try {
      end_lapsed(std::time(nullptr));
    } catch (const std::exception& error) {
      log::error("{}", error.what());
    }
    lock.lock();
  }
}

void Gate::end_lapsed(std::int64_t now) {
  std::vector<Lasting> open;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(lasting_, [](const Lasting& call) { return call.stream.expired(); });
    open = lasting_;
  }

  // Without the lock: ending a stream calls gRPC.
  for (const Lasting& call : open) {
    const auto why = authority_.lapse(call.caller, now);
    if (!why) continue;
    if (const auto stream = call.stream.lock()) stream->lapse(make_status(*why));
  }
}

void Gate::count(const std::string& method, const grpc::Status& status,
                 std::chrono::duration<double> taken) {
  const std::lock_guard lock(figures_mutex_);
  figures_.seconds.try_emplace({method, name_of(status.error_code())}, CallFigures::bounds_s)
      .first->second.add(taken.count());
  if (status.ok()) return;
  const auto why = refusal::read_details(status.error_details());
  if (why && !why->limit.empty()) ++figures_.refused[why->limit];
}

CallFigures Gate::figures() {
  const std::lock_guard lock(figures_mutex_);
  return figures_;
}

void Gate::record(v1::AuditEvent event, const access::Caller& caller, const access::CallRule& rule,
                  const std::string& peer, const grpc::Status& status) {
  // Where a caller reads only their own, what is another's is refused as not there.
  const bool without_permission =
      status.error_code() == grpc::UNAUTHENTICATED ||
      status.error_code() == grpc::PERMISSION_DENIED ||
      (status.error_code() == grpc::NOT_FOUND && authority_.reads_own_only(caller));
  const bool reads = rule.access.role() == v1::VIEWER && event.reason().empty();
  if (reads && !without_permission) return;

  const std::string user = caller.proven() ? caller.name : "";
  if (!status.ok() && !recorded_refusals_.take(user, std::chrono::steady_clock::now())) return;

  if (event.user().empty()) event.set_user(caller.name);
  if (caller.proven()) {
    event.set_role(access::text_of(caller.role));
    event.set_proof(access::text_of(caller.by));
  }
  event.set_from(peer);
  event.set_call(rule.name);
  event.set_outcome(name_of(status.error_code()));
  if (!status.ok()) event.set_reason(status.error_message());

  try {
    audit_.append(std::move(event));
  } catch (const std::exception& error) {
    // The call has taken effect and cannot be refused any more.
    log::error("{}", error.what());
  }
}

}  // namespace dccast::service
