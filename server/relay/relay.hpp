#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "server/relay/held_memory.hpp"
#include "server/relay/listener.hpp"
#include "server/relay/peer_table.hpp"
#include "server/relay/tls_context.hpp"

namespace dccast::relay {

/// How many connections of a listener may be open.
struct Bounds {
  std::size_t connections = 1;
  std::size_t per_peer = SIZE_MAX;  ///< of one machine
};

/// Stands between clients and gRPC 1.51, which shows nothing of a connection but its calls, and
/// those when they have cost their memory already. The relay accepts connections up to a bound,
/// terminates TLS, ends a connection whose client is hostile (FrameGuard), and hands gRPC one end
/// of a socket pair for each. A header of each call names its connection (PeerTable).
/// A connection that is closed at once is UNAVAILABLE to its client.
class Relay {
public:
  /// @param peers  outlives this object
  /// @param serve  gives a socket to gRPC, which closes it
  Relay(PeerTable& peers, std::function<void(int)> serve, const MemoryBounds& memory);
  ~Relay();

  /// Accepts connections of this listener from start() on. Certificates that are replaced hold for
  /// new connections within a second.
  /// @param listener  outlives this object @param tls  nothing: without TLS
  /// @throws std::runtime_error  the files of TLS cannot be used
  void add(const Listener& listener, const Bounds& bounds, std::optional<TlsFiles> tls);
  void start();

  /// Accepts no more. gRPC gets no further socket once this has returned.
  void stop_accepting();
  /// Ends all connections. Those that gRPC has closed have a second to get what it has sent.
  void close();

private:
  class Loop;
  const std::unique_ptr<Loop> loop_;
};

}  // namespace dccast::relay
