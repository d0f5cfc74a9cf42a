#pragma once

// Only for the sources of this room: Asio and Beast take seconds to compile.
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <functional>
#include <thread>

#include "proto/http/server.hpp"

namespace dccast::http {

class PeerStream;

/// What all connections of a server share.
struct Service {
  /// Bounds on requests, names by which this server is called, and what answers.
  Limits limits;
  IsOwnHost is_own_host;
  Handler handler;
  boost::asio::ssl::context* tls = nullptr;  ///< null: HTTP
  std::atomic<bool> stopping = false;
};

/// One connection and the thread that serves it. The thread waits for the peer in `context` alone,
/// so that every wait has an end and can be ended from another thread.
class Connection {
public:
  /// @param service  outlives the connection
  explicit Connection(const Service& service) : service_(service) {}
  Connection(const Connection&) = delete;

  /// The accepted socket must belong to it.
  boost::asio::io_context& context() { return context_; }

  /// Begins to serve the peer. @param ended  called by the thread at its end
  void begin(boost::asio::ip::tcp::socket socket, std::function<void()> ended);
  /// Ends the wait for the peer, now or when it begins. From any thread.
  void close();

  /// Ends the connection once the request at work is answered. From any thread.
  void leave() { leaving_ = true; }

  /// Nothing is being computed for the peer: it has not sent its request, or not taken its reply.
  bool waits_for_peer() const { return waits_for_peer_; }

private:
  /// Serves requests of one client until it leaves or exceeds a bound.
  class Session;

  const Service& service_;
  boost::asio::io_context context_{1};
  PeerStream* open_ = nullptr;  // used by the thread alone
  std::atomic<bool> waits_for_peer_ = true;
  std::atomic<bool> leaving_ = false;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace dccast::http
