#pragma once

// Only for the sources of this room: Asio and Beast take seconds to compile.
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <chrono>
#include <optional>

namespace dccast::http {

/// The bytes of one peer, over TCP or TLS, read and written by one thread that waits for each
/// operation. Every wait ends with the time limit, or by close() from a handler of `context`. It is
/// a SyncReadStream and SyncWriteStream of Asio, so that what reads and writes messages is compiled
/// once for both.
class PeerStream {
public:
  using error_code = boost::system::error_code;

  /// @param context  of the socket; run by the operations alone
  /// @param tls      null: TCP
  PeerStream(boost::asio::io_context& context, boost::asio::ip::tcp::socket socket,
             boost::asio::ssl::context* tls);

  /// The limit on all that follows, until it is set again.
  void expires_after(std::chrono::milliseconds time) { socket_.expires_after(time); }

  error_code handshake();
  /// Says to the peer of a TLS connection that nothing follows.
  void shut_down();
  /// Ends the sending, and receives what the peer still sends.
  void drain();
  void close() { socket_.close(); }

  /// @return number of bytes, of the first buffer that is not empty
  template <class Buffers>
  std::size_t read_some(const Buffers& buffers, error_code& error) {
    return read_one(first_of<boost::asio::mutable_buffer>(buffers), error);
  }
  template <class Buffers>
  std::size_t write_some(const Buffers& buffers, error_code& error) {
    return write_one(first_of<boost::asio::const_buffer>(buffers), error);
  }

  /// As the concepts want them. @throws boost::system::system_error
  template <class Buffers>
  std::size_t read_some(const Buffers& buffers) {
    return checked(&PeerStream::read_some<Buffers>, buffers);
  }
  template <class Buffers>
  std::size_t write_some(const Buffers& buffers) {
    return checked(&PeerStream::write_some<Buffers>, buffers);
  }

private:
  template <class Buffer, class Buffers>
  static Buffer first_of(const Buffers& buffers) {
    const auto end = boost::asio::buffer_sequence_end(buffers);
    for (auto it = boost::asio::buffer_sequence_begin(buffers); it != end; ++it)
      if (const Buffer buffer(*it); buffer.size() > 0) return buffer;
    return {};
  }
  template <class Buffers>
  std::size_t checked(std::size_t (PeerStream::*some)(const Buffers&, error_code&),
                      const Buffers& buffers) {
    error_code error;
    const std::size_t count = (this->*some)(buffers, error);
    if (error) throw boost::system::system_error(error);
    return count;
  }

  std::size_t read_one(boost::asio::mutable_buffer buffer, error_code& error);
  std::size_t write_one(boost::asio::const_buffer buffer, error_code& error);

  /// Starts one operation and waits for its end.
  /// @param start  receives the handler that the operation calls at its end
  template <class Start>
  std::size_t wait(error_code& error, const Start& start);

  boost::asio::io_context& context_;
  boost::beast::tcp_stream socket_;
  std::optional<boost::beast::ssl_stream<boost::beast::tcp_stream&>> tls_;
};

}  // namespace dccast::http
