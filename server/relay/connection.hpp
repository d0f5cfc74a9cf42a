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

/// Owner of connections. All calls come from the relay thread.
class ConnectionOwner {
public:
  virtual ~ConnectionOwner() = default;
  /// Table in which a connection enters its peer for the calls.
  virtual PeerTable& peers() = 0;
  /// Passes one end of a socket pair to gRPC. @param socket  ownership passes with it
  virtual void serve(int socket) = 0;
  /// Bounds on the memory of unfinished requests.
  virtual const MemoryBounds& memory() const = 0;
  /// Reports that unfinished requests of a connection hold this much more memory [bytes].
  virtual void on_growth(std::size_t bytes) = 0;
  /// Reports calls that were taken back.
  virtual void on_resets(const Peer& peer, std::size_t resets) = 0;
  /// When a peer is read again, since it pays for such calls; a time that has passed: at once.
  virtual std::chrono::steady_clock::time_point reads_at(const Peer& peer) const = 0;
  /// @param hostile  whether the client's behaviour ended the connection
  virtual void on_end(const Connection& connection, bool hostile) = 0;
};

/// Relays one connection between its client and gRPC: terminates TLS, checks the client's frames,
/// and reads from one side only as much as the other side takes. A connection lives while it waits
/// for something. Used only by the relay thread.
class Connection : public std::enable_shared_from_this<Connection> {
public:
  using Clock = std::chrono::steady_clock;

  /// @param socket  of the client; ownership passes with it
  /// @param tls     null for a connection without TLS
  Connection(boost::asio::io_context& loop, ConnectionOwner& owner, int socket, Peer peer,
             SSL_CTX* tls);
  /// Closes the sockets that are still open.
  ~Connection();

  /// @param when  earliest time of the handshake
  void start_at(Clock::time_point when);
  /// Closes both sides; repeated calls have no effect.
  /// @param hostile  reason if the client is hostile; otherwise empty
  void end(std::string_view hostile = "");

  bool in_handshake() const { return !service_.has_value(); }
  /// Whether the client has sent no more than its greeting.
  bool is_silent() const;
  const Peer& peer() const { return peer_; }
  Clock::time_point since() const { return since_; }
  /// Memory of its unfinished requests.
  HeldMemory held() const;

private:
  using Socket = boost::asio::posix::stream_descriptor;
  using Step = void (Connection::*)();

  /// One side of the connection.
  struct Side {
    /// Non-blocking descriptor, watched by the loop.
    Socket socket;
    /// The bytes of this side, encrypted or not.
    std::unique_ptr<ByteStream> stream;
    std::string unsent{};  ///< bytes that this side has not accepted yet
  };

  /// Sets the time limit of the handshake and begins it.
  void start();
  /// Continues the handshake of TLS until it is done or has failed.
  void shake_hands();
  /// Makes the socket pair, hands one end to gRPC, and begins to relay.
  void open();
  /// Reads from the client, checks the frames, and sends them to gRPC.
  void carry_requests();
  /// Reads from gRPC and sends to the client.
  void carry_answers();
  /// Takes a step with a new budget, unless the connection has ended.
  void take_turn(Step step);
  /// @return whether everything was sent; otherwise `retry` runs later, or the connection has ended
  bool send(Side& to, std::string_view bytes, Step retry);
  /// Sends what is left of an earlier send(). @return as send()
  bool send_rest(Side& to, Step retry);
  /// Takes the next step as the transfer needs: once the socket can be read or written, or after
  /// others. Ends the connection if the transfer says so.
  void wait(Side& side, const Transfer& transfer, Step next);
  /// Lets other connections have their turn before the next step.
  void yield(Step next);
  /// Takes the next step at that time.
  void pause(Clock::time_point until, Step next);
  /// Reports the calls that were taken back to the owner.
  void report_resets();
  /// Ends the connection unless it has ended before.
  void end_after(std::chrono::seconds time);

  boost::asio::io_context& loop_;
  ConnectionOwner& owner_;
  Peer peer_;
  const Clock::time_point since_ = Clock::now();
  TurnBudget turn_;
  Side client_;
  std::optional<Side> service_;  ///< gRPC, after the handshake
  boost::asio::steady_timer deadline_, pause_;
  std::string name_;  ///< key in the table of peers
  std::optional<FrameGuard> guard_;
  std::uint64_t received_ = 0;  ///< from the client, decrypted [bytes]
  bool ended_ = false;
};

}  // namespace dccast::relay
