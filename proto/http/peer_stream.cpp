#include "proto/http/peer_stream.hpp"

#include <array>
#include <boost/asio/ssl/stream.hpp>

namespace dccast::http {

namespace asio = boost::asio;
using asio::ip::tcp;

PeerStream::PeerStream(asio::io_context& context, tcp::socket socket, asio::ssl::context* tls)
    : context_(context), socket_(std::move(socket)) {
  // Header and body of a reply are written one after the other: neither waits for the other.
  error_code ignored;
  socket_.socket().set_option(tcp::no_delay(true), ignored);
  if (tls != nullptr) tls_.emplace(socket_, *tls);
}

template <class Start>
std::size_t PeerStream::wait(error_code& error, const Start& start) {
  std::size_t bytes = 0;
  start([&](const error_code& why, std::size_t count = 0) {
    error = why;
    bytes = count;
  });
  context_.restart();
  context_.run();
  return bytes;
}

PeerStream::error_code PeerStream::handshake() {
  error_code error;
  if (tls_)
    wait(error, [&](auto done) {
      tls_->async_handshake(asio::ssl::stream_base::server, std::move(done));
    });
  return error;
}

void PeerStream::shut_down() {
  error_code ignored;
  if (tls_) wait(ignored, [&](auto done) { tls_->async_shutdown(std::move(done)); });
}

void PeerStream::drain() {
  error_code error;
  socket_.socket().shutdown(tcp::socket::shutdown_send, error);

  // Below TLS: what comes is not looked at.
  std::array<char, 16 * 1024> rest{};
  error = {};
  while (!error)
    wait(error, [&](auto done) { socket_.async_read_some(asio::buffer(rest), std::move(done)); });
}

std::size_t PeerStream::read_one(asio::mutable_buffer buffer, error_code& error) {
  return wait(error, [&](auto done) {
    tls_ ? tls_->async_read_some(buffer, std::move(done))
         : socket_.async_read_some(buffer, std::move(done));
  });
}

std::size_t PeerStream::write_one(asio::const_buffer buffer, error_code& error) {
  return wait(error, [&](auto done) {
    tls_ ? tls_->async_write_some(buffer, std::move(done))
         : socket_.async_write_some(buffer, std::move(done));
  });
}

}  // namespace dccast::http
