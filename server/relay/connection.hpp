#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/relay/byte_stream.hpp"
#include "server/relay/frame_guard.hpp"
#include "server/relay/held_memory.hpp"
#include "server/relay/peer_table.hpp"

namespace dccast::relay {

class Connection;

/// Owner of connections; each call comes on the thread of the relay.
class ConnectionOwner {
public:
  virtual ~ConnectionOwner() = default;
  virtual PeerTable& peers() = 0;
  /// Hands one end of a socket pair to gRPC. @param socket  is taken over
  virtual void serve(int socket) = 0;
  virtual const MemoryBounds& memory() const = 0;
  /// Unfinished requests of a connection hold so many more bytes.
  virtual void on_growth(std::size_t bytes) = 0;
  /// @param hostile  for what its client has sent
  virtual void on_end(const Connection& connection, bool hostile) = 0;
};

/// Carries one connection between its client and gRPC: terminates TLS, looks at the frames of the
/// client, and reads from one side no more than the other side takes. It lives as long as it waits
/// for something. For the thread of the relay alone.
class Connection : public std::enable_shared_from_this<Connection> {
public:
  using Clock = std::chrono::steady_clock;

  /// @param socket  of the client, is taken over
  /// @param tls     null: none
  Connection(boost::asio::io_context& loop, ConnectionOwner& owner, int socket, Peer peer,
             SSL_CTX* tls);
  ~Connection();

  /// @param when  not before
  void start_at(Clock::time_point when);
  /// Closes both sides; the second time it does nothing. @param hostile  why; empty: it is not
  void end(std::string_view hostile = "");

  bool in_handshake() const { return !service_.has_value(); }
  /// Whether its client has sent no more than greetings.
  bool is_silent() const;
  const Peer& peer() const { return peer_; }
  Clock::time_point since() const { return since_; }
  /// What its unfinished requests hold.
  HeldMemory held() const;

private:
  using Socket = boost::asio::posix::stream_descriptor;
  using Step = void (Connection::*)();

  /// One side of the connection.
  struct Side {
    Socket socket;
    std::unique_ptr<ByteStream> stream;
    std::string unsent{};  ///< what this side does not take yet
  };

  void start();
  void shake_hands();
  void open();
  void carry_requests();
  void carry_answers();
  /// @return whether all was sent; otherwise `retry` follows, or the connection has ended
  bool send(Side& to, std::string_view bytes, Step retry);
  bool send_rest(Side& to, Step retry);
  void wait(Side& side, const Transfer& transfer, Step next);
  void yield(Step next);
  void end_after(std::chrono::seconds time);

  boost::asio::io_context& loop_;
  ConnectionOwner& owner_;
  Peer peer_;
  const Clock::time_point since_ = Clock::now();
  Side client_;
  std::optional<Side> service_;  ///< gRPC, after the handshake
  boost::asio::steady_timer deadline_;
  std::string name_;  ///< in the table of peers
  std::optional<FrameGuard> guard_;
  std::uint64_t received_ = 0;  ///< from the client, decrypted [bytes]
  bool ended_ = false;
};

}  // namespace dccast::relay
