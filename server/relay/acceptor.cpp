#include "server/relay/acceptor.hpp"

#include <fcntl.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <optional>
#include <utility>

#include "server/jobs/log.hpp"

namespace dccast::relay {

namespace {

using std::chrono::milliseconds;

// A client whose connection was ended for what it sent comes back at once. Each such end delays its
// next connections.
constexpr milliseconds delay_per_hostile{25}, longest_delay{5000};
/// A connection without a request after this time may be ended in favour of another.
constexpr std::chrono::seconds time_to_first_request{1};
constexpr std::size_t most_in_handshake = 64;

/// The user of this machine who has made a connection to a Unix socket of ours.
/// @return nothing: the connection is of TCP, or the system does not say
std::optional<unsigned> user_of_peer(int socket, const sockaddr_storage& from) {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (from.ss_family != AF_UNIX ||
      ::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0)
    return std::nullopt;
  return credentials.uid;
}

/// Connections of the Unix socket that are kept for root, so that an administrator always gets in.
constexpr std::size_t kept_for_root = 16;

bool is_root(const Peer& peer) {
  return peer.user_id == 0U;
}

bool have_one_origin(const Peer& left, const Peer& right) {
  return left.user_id == right.user_id && left.host == right.host;
}

}  // namespace

Acceptor::Acceptor(boost::asio::io_context& loop, ConnectionOwner& owner, const Listener& listener,
                   const Bounds& bounds, std::unique_ptr<TlsContext> tls)
    : loop_(loop),
      owner_(owner),
      bounds_(bounds),
      tls_(std::move(tls)),
      socket_(loop, ::fcntl(listener.socket(), F_DUPFD_CLOEXEC, 0)),
      pause_(loop) {}

void Acceptor::refresh_certificates() {
  if (tls_) tls_->refresh();
}

void Acceptor::wait_for_client() {
  socket_.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                     [this](const boost::system::error_code& closed) {
                       if (!closed) accept();
                     });
}

void Acceptor::stop_accepting() {
  boost::system::error_code ignored;
  pause_.cancel(ignored);
  socket_.close(ignored);

  // gRPC would still receive these after their handshake.
  end_those([](const Connection& connection) { return connection.in_handshake(); });
}

void Acceptor::end_all() {
  end_those([](const Connection&) { return true; });
}

bool Acceptor::remove(const Connection& connection, bool hostile) {
  const auto removed = std::erase_if(
      connections_, [&](const auto& candidate) { return candidate.get() == &connection; });
  if (removed > 0 && hostile) delay_next(connection.peer());
  return removed > 0;
}

void Acceptor::delay_next(const Peer& peer) {
  const auto now = Connection::Clock::now();
  std::erase_if(not_before_, [&](const auto& entry) { return entry.second <= now; });
  auto& time = not_before_[peer.origin()];
  time = std::min(std::max(time, now) + delay_per_hostile, now + longest_delay);
}

Connection::Clock::time_point Acceptor::first_turn(const Peer& peer) const {
  const auto found = not_before_.find(peer.origin());
  const auto reads_at = owner_.reads_at(peer);
  return found == not_before_.end() ? reads_at : std::max(found->second, reads_at);
}

void Acceptor::end_those(const Condition& condition) {
  const auto connections = connections_;  // a copy: end() removes from the vector
  for (const auto& connection : connections)
    if (condition(*connection)) connection->end();
}

void Acceptor::accept() {
  sockaddr_storage from{};
  socklen_t size = sizeof from;
  const int socket = ::accept4(socket_.native_handle(), reinterpret_cast<sockaddr*>(&from), &size,
                               SOCK_CLOEXEC | SOCK_NONBLOCK);

  if (socket >= 0) {
    const std::string host = host_of(from, size);
    admit(socket, {.host = host,
                   .address = uri_of(host, from),
                   .over_tls = tls_ != nullptr,
                   .user_id = user_of_peer(socket, from)});
  } else if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS) {
    // The accepted client waits in the system's queue; a pause avoids a busy loop meanwhile.
    constexpr milliseconds pause_after_refusal{100};
    log::warn("cannot accept a connection: {}", ::strerror(errno));
    pause_.expires_after(pause_after_refusal);
    return pause_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) wait_for_client();
    });
  }

  wait_for_client();
}

void Acceptor::admit(int socket, Peer peer) {
  const bool was_full = std::exchange(full_, !make_room(peer));
  // Logged once, not for each connection that a full acceptor closes.
  if (full_) {
    if (!was_full)
      log::warn(
          "all connections are in use, or those of {}; further ones are closed until one ends",
          peer.origin());
    ::close(socket);
    return;
  }
  if (tls_) bound_handshakes();

  try {
    const auto turn = first_turn(peer);
    const auto connection = std::make_shared<Connection>(loop_, owner_, socket, std::move(peer),
                                                         tls_ ? &tls_->get() : nullptr);
    connections_.push_back(connection);
    connection->start_at(turn);
  } catch (const std::exception& error) {
    log::warn("a connection is closed: {}", error.what());
  }
}

bool Acceptor::make_room(const Peer& peer) {
  const auto is_of_same_origin = [&](const Peer& other) { return have_one_origin(other, peer); };
  const auto has_its_share = [&] {
    return static_cast<std::size_t>(
               std::ranges::count_if(connections_, [&](const auto& connection) {
                 return is_of_same_origin(connection->peer());
               })) >= bounds_.per_peer;
  };
  const bool has_no_bound = is_root(peer) || (peer.user_id && peer.user_id == bounds_.web_user_id);
  if (!has_no_bound && has_its_share() && !end_a_silent_one(is_of_same_origin)) return false;

  const bool is_other_local_user = peer.user_id && !is_root(peer);
  const std::size_t kept = std::min(kept_for_root, bounds_.connections / 10);
  const std::size_t most = bounds_.connections - (is_other_local_user ? kept : 0);
  return connections_.size() < most || end_a_silent_one([](const Peer&) { return true; });
}

bool Acceptor::end_a_silent_one(const std::function<bool(const Peer&)>& condition) {
  const auto now = Connection::Clock::now();
  const auto may_give_way = [&](const auto& connection) {
    return now - connection->since() >= time_to_first_request && condition(connection->peer()) &&
           connection->is_silent();
  };

  const auto found = std::ranges::find_if(connections_, may_give_way);  // oldest first
  if (found == connections_.end()) return false;
  std::shared_ptr(*found)->end();
  return true;
}

/// Bounds concurrent handshakes, which cost most of the processor time. The host with the most of
/// them loses its oldest.
void Acceptor::bound_handshakes() {
  std::map<std::string, std::size_t> of_host;
  std::size_t handshakes = 0;
  for (const auto& connection : connections_) {
    if (!connection->in_handshake()) continue;
    ++of_host[connection->peer().host];
    ++handshakes;
  }
  if (handshakes < most_in_handshake) return;

  const auto most =
      std::ranges::max_element(of_host, {}, [](const auto& entry) { return entry.second; });
  const auto oldest = std::ranges::find_if(connections_, [&](const auto& connection) {
    return connection->in_handshake() && connection->peer().host == most->first;
  });
  std::shared_ptr(*oldest)->end();
}

}  // namespace dccast::relay
