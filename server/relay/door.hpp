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
/// ended. If each has made a request, or a machine has its maximum, a further connection is closed.
/// Used only by the relay thread.
class Door {
public:
  /// @param tls  null for connections without TLS
  Door(boost::asio::io_context& loop, ConnectionOwner& owner, const Listener& listener,
       const Bounds& bounds, std::unique_ptr<TlsContext> tls);

  /// Reloads TLS files that have changed.
  void refresh_certificates();
  const std::vector<std::shared_ptr<Connection>>& connections() const { return connections_; }

  void wait_for_client();
  void stop_accepting();
  void end_all();
  /// @return whether the connection belonged to this door
  bool remove(const Connection& connection, bool hostile);

private:
  using Condition = std::function<bool(const Connection&)>;

  void end_those(const Condition& condition);
  void delay_next(const Peer& peer);
  Connection::Clock::time_point first_turn(const Peer& peer) const;
  void accept();
  void admit(int socket, Peer peer);
  bool make_room(const std::string& host);
  bool end_a_silent_one(const std::string& host);
  void bound_handshakes();

  boost::asio::io_context& loop_;
  ConnectionOwner& owner_;
  const Bounds bounds_;
  const std::unique_ptr<TlsContext> tls_;
  boost::asio::posix::stream_descriptor socket_;
  boost::asio::steady_timer pause_;
  std::vector<std::shared_ptr<Connection>> connections_;  ///< oldest first
  /// Earliest begin of the next connection, by origin of a hostile client.
  std::map<std::string, Connection::Clock::time_point> not_before_;
  bool full_ = false;
};

}  // namespace dccast::relay
