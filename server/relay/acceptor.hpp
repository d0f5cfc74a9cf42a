#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "server/relay/connection.hpp"
#include "server/relay/listener.hpp"
#include "server/relay/relay.hpp"
#include "server/relay/tls_context.hpp"

namespace dccast::relay {

/// A listener and its connections. When all are in use, the oldest connection without a request is
/// ended. If each has made a request, or an origin has its maximum, a further connection is closed.
/// Root of this machine has no maximum, and some connections that no other local user gets. Used
/// only by the relay thread.
class Acceptor {
public:
  /// @param tls  null for connections without TLS
  Acceptor(boost::asio::io_context& loop, ConnectionOwner& owner, const Listener& listener,
           const Bounds& bounds, std::unique_ptr<TlsContext> tls);

  /// Reloads TLS files that have changed.
  void refresh_certificates();
  /// Open connections, the oldest first.
  const std::vector<std::shared_ptr<Connection>>& connections() const { return connections_; }

  /// Accepts clients when they come, until stop_accepting().
  void wait_for_client();
  /// Closes the listener for this acceptor; open connections stay.
  void stop_accepting();
  /// Ends all connections, as at the end of the daemon.
  void end_all();
  /// @return whether the connection belonged to this acceptor
  bool remove(const Connection& connection, bool hostile);

private:
  using Condition = std::function<bool(const Connection&)>;

  /// Ends the connections for which a condition holds.
  void end_those(const Condition& condition);
  /// Makes the next connection of a hostile client wait, longer each time.
  void delay_next(const Peer& peer);
  /// When a connection may begin its handshake: at once, or after the delay of its origin.
  Connection::Clock::time_point first_turn(const Peer& peer) const;
  /// Accepts a waiting client, then waits for the next one.
  void accept();
  /// Adds a connection, or closes its socket if there is no room. @param socket  ownership passes
  /// with it
  void admit(int socket, Peer peer);
  /// Whether a connection of this peer fits, after a silent one was ended if necessary.
  bool make_room(const Peer& peer);
  /// Ends the oldest connection without a request after its first second, if its peer fulfils the
  /// condition. @return false if there is none
  bool end_a_silent_one(const std::function<bool(const Peer&)>& condition);
  /// Bounds concurrent handshakes: the host with the most of them loses its oldest.
  void bound_handshakes();

  boost::asio::io_context& loop_;
  ConnectionOwner& owner_;
  const Bounds bounds_;
  const std::unique_ptr<TlsContext> tls_;
  boost::asio::posix::stream_descriptor socket_;
  /// Pause after an accept that failed, as when descriptors are used up.
  boost::asio::steady_timer pause_;
  std::vector<std::shared_ptr<Connection>> connections_;  ///< oldest first
  /// Earliest begin of the next connection, by origin of a hostile client.
  std::map<std::string, Connection::Clock::time_point> not_before_;
  /// Whether the log already states that all connections are in use.
  bool full_ = false;
};

}  // namespace dccast::relay
