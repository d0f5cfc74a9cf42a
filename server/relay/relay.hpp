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

/// Bounds on the open connections of a listener.
struct Bounds {
  /// Of all machines together.
  std::size_t connections = 1;
  std::size_t per_peer = SIZE_MAX;  ///< connections of one other machine, or one local user
  /// Local user whose connections serve many users, and have no such bound; empty: none.
  std::optional<unsigned> web_user_id{};
};

/// Relay between clients and gRPC 1.51, which exposes nothing of a connection but its calls, and
/// calls only after spending memory on them. The relay accepts connections up to a bound,
/// terminates TLS, ends connections of hostile clients (FrameGuard), and hands gRPC one end of a
/// socket pair for each. It adds to each call a header that names its connection (PeerTable). A
/// client whose connection is closed at once sees UNAVAILABLE.
class Relay {
public:
  /// @param peers  outlives this object
  /// @param serve  passes a socket to gRPC, which closes it
  Relay(PeerTable& peers, std::function<void(int)> serve, const MemoryBounds& memory);
  /// Ends all connections and the thread.
  ~Relay();

  /// Adds a listener, whose connections are accepted after start(). New certificates apply to new
  /// connections within a second.
  /// @param listener  outlives this object
  /// @param tls       empty: without TLS
  /// @throws std::runtime_error  the files of TLS cannot be used
  void add(const Listener& listener, const Bounds& bounds, std::optional<TlsFiles> tls);
  /// Starts the thread, which accepts and relays.
  void start();

  /// Stops accepting. gRPC receives no further socket once this has returned.
  void stop_accepting();
  /// Ends all connections; clients have one second to receive what gRPC has sent.
  void close();

private:
  class Loop;
  const std::unique_ptr<Loop> loop_;
};

}  // namespace dccast::relay
