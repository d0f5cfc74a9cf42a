#pragma once

// Only for the sources of this room: Asio and Beast take seconds to compile.
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <optional>
#include <utility>

namespace dccast::http {

/// The bytes of one peer, over TCP, TLS or a Unix socket. It is an AsyncStream of Asio, so that
/// what reads and writes messages is compiled once for both.
class PeerStream {
public:
  using Socket = boost::asio::generic::stream_protocol::socket;
  using executor_type = Socket::executor_type;

  /// @param tls  null: bytes are not enciphered
  PeerStream(Socket socket, boost::asio::ssl::context* tls) : socket_(std::move(socket)) {
    // Header and body of a reply are written one after the other: neither waits for the other.
    boost::system::error_code ignored;
    socket_.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
    if (tls != nullptr) tls_.emplace(socket_, *tls);
  }

  executor_type get_executor() { return socket_.get_executor(); }
  /// Below TLS.
  Socket& socket() { return socket_; }

  template <class Buffers, class Done>
  void async_read_some(const Buffers& buffers, Done&& done) {
    tls_ ? tls_->async_read_some(buffers, std::forward<Done>(done))
         : socket_.async_read_some(buffers, std::forward<Done>(done));
  }
  template <class Buffers, class Done>
  void async_write_some(const Buffers& buffers, Done&& done) {
    tls_ ? tls_->async_write_some(buffers, std::forward<Done>(done))
         : socket_.async_write_some(buffers, std::forward<Done>(done));
  }
  template <class Done>
  void async_handshake(Done&& done) {
    tls_->async_handshake(boost::asio::ssl::stream_base::server, std::forward<Done>(done));
  }
  /// Says to the peer of a TLS connection that nothing follows.
  template <class Done>
  void async_shutdown(Done&& done) {
    tls_->async_shutdown(std::forward<Done>(done));
  }
  bool has_tls() const { return tls_.has_value(); }

private:
  Socket socket_;
  std::optional<boost::asio::ssl::stream<Socket&>> tls_;
};

}  // namespace dccast::http
