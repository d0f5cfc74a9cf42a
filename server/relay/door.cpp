#include "server/relay/door.hpp"

#include <fcntl.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <utility>

#include "server/jobs/log.hpp"

namespace dccast::relay {

namespace {

using std::chrono::milliseconds;

/// A connection that has made no request for so long may give way.
constexpr std::chrono::seconds time_to_first_request{1};
constexpr std::size_t most_in_handshake = 64;

}  // namespace

Door::Door(boost::asio::io_context& loop, ConnectionOwner& owner, const Listener& listener,
           const Bounds& bounds, std::unique_ptr<TlsContext> tls)
    : loop_(loop),
      owner_(owner),
      bounds_(bounds),
      tls_(std::move(tls)),
      socket_(loop, ::fcntl(listener.socket(), F_DUPFD_CLOEXEC, 0)),
      pause_(loop) {}

void Door::refresh_certificates() {
  if (tls_) tls_->refresh();
}

void Door::wait_for_client() {
  socket_.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                     [this](const boost::system::error_code& closed) {
                       if (!closed) pace();
                     });
}

void Door::stop_accepting() {
  boost::system::error_code ignored;
  pause_.cancel(ignored);
  socket_.close(ignored);

  // Those would still be handed to gRPC.
  end_those([](const Connection& connection) { return connection.in_handshake(); });
}

void Door::end_all() {
  end_those([](const Connection&) { return true; });
}

bool Door::remove(const Connection& connection, bool hostile) {
  const auto removed = std::erase_if(
      connections_, [&](const auto& candidate) { return candidate.get() == &connection; });
  if (removed > 0 && hostile) ++hostile_;
  return removed > 0;
}

void Door::end_those(const Condition& condition) {
  const auto all = connections_;  // each end removes one
  for (const auto& connection : all)
    if (condition(*connection)) connection->end();
}

/// A client whose connection was ended for what it sent comes back at once. Each such end delays
/// the next connection, whichever client it is from: local ones have the same address.
void Door::pace() {
  constexpr milliseconds per_ended{25};
  constexpr int most_at_once = 8;
  accept_after(std::min(std::exchange(hostile_, 0), most_at_once) * per_ended);
}

void Door::accept_after(milliseconds pause) {
  if (pause == milliseconds(0)) return accept();
  pause_.expires_after(pause);
  pause_.async_wait([this](const boost::system::error_code& cancelled) {
    if (!cancelled) accept();
  });
}

void Door::accept() {
  sockaddr_storage from{};
  socklen_t size = sizeof from;
  const int socket = ::accept4(socket_.native_handle(), reinterpret_cast<sockaddr*>(&from), &size,
                               SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (socket >= 0) {
    const std::string host = host_of(from, size);
    admit(socket, {.host = host, .address = uri_of(host, from), .over_tls = tls_ != nullptr});
  } else if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS) {
    // The client stays in the queue of the system.
    constexpr milliseconds pause_after_refusal{100};
    log::warn("cannot accept a connection: {}", ::strerror(errno));
    return accept_after(pause_after_refusal);
  }
  wait_for_client();
}

void Door::admit(int socket, Peer peer) {
  const bool was_full = std::exchange(full_, !make_room(peer.host));
  if (full_) {
    if (!was_full)
      log::warn(
          "all connections are in use, or those of {}; further ones are closed until one ends",
          peer.host);
    ::close(socket);
    return;
  }
  if (tls_) bound_handshakes();

  try {
    const auto connection = std::make_shared<Connection>(loop_, owner_, socket, std::move(peer),
                                                         tls_ ? &tls_->get() : nullptr);
    connections_.push_back(connection);
    connection->start();
  } catch (const std::exception& error) {
    log::warn("a connection is closed: {}", error.what());
  }
}

bool Door::make_room(const std::string& host) {
  const auto has_its_share = [&] {
    return static_cast<std::size_t>(std::ranges::count(connections_, host, [](const auto& other) {
             return other->host();
           })) >= bounds_.per_peer;
  };
  if (has_its_share() && !end_a_silent_one(host)) return false;
  return connections_.size() < bounds_.connections || end_a_silent_one("");
}

/// Ends the oldest connection that has not made a request in its first second, for one that may.
/// @param host  only one of this; empty: any
bool Door::end_a_silent_one(const std::string& host) {
  const auto now = Connection::Clock::now();
  const auto may_give_way = [&](const auto& connection) {
    return now - connection->since() >= time_to_first_request &&
           (host.empty() || connection->host() == host) && connection->is_silent();
  };

  const auto found = std::ranges::find_if(connections_, may_give_way);  // oldest first
  if (found == connections_.end()) return false;
  std::shared_ptr(*found)->end();
  return true;
}

/// Handshakes cost most of the time of a processor. The oldest of the machine that has most of
/// them gives way.
void Door::bound_handshakes() {
  std::map<std::string, std::size_t> of_host;
  std::size_t all = 0;
  for (const auto& connection : connections_) {
    if (!connection->in_handshake()) continue;
    ++of_host[connection->host()];
    ++all;
  }
  if (all < most_in_handshake) return;

  const auto most =
      std::ranges::max_element(of_host, {}, [](const auto& entry) { return entry.second; });
  const auto oldest = std::ranges::find_if(connections_, [&](const auto& connection) {
    return connection->in_handshake() && connection->host() == most->first;
  });
  std::shared_ptr(*oldest)->end();
}

}  // namespace dccast::relay
