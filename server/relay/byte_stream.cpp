#include "server/relay/byte_stream.hpp"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <sys/socket.h>

#include <cerrno>
#include <stdexcept>
#include <string>

#include "server/access/certificates.hpp"

namespace dccast::relay {

namespace {

using Outcome = Transfer::Outcome;

class PlainStream final : public ByteStream {
public:
  explicit PlainStream(int socket) : socket_(socket) {}

  Transfer handshake() override { return {}; }

  Transfer read(char* buffer, std::size_t room) override {
    return transfer(::recv(socket_, buffer, room, 0), Outcome::wait_until_readable);
  }

  Transfer write(std::string_view bytes) override {
    return transfer(::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
                    Outcome::wait_until_writable);
  }

  void close() override { ::shutdown(socket_, SHUT_WR); }
  void describe(Peer&) const override {}

private:
  static Transfer transfer(ssize_t moved, Outcome otherwise) {
    if (moved > 0) return {Outcome::moved, static_cast<std::size_t>(moved)};
    if (moved < 0 && (errno == EAGAIN || errno == EINTR)) return {otherwise};
    return {Outcome::ended};
  }

  const int socket_;
};

/// The client's certificate as PEM; empty: it has shown none.
std::string certificate_of(const SSL* session) {
  const std::unique_ptr<X509, decltype(&::X509_free)> certificate(
      ::SSL_get1_peer_certificate(session), &::X509_free);
  if (!certificate) return "";

  const std::unique_ptr<BIO, decltype(&::BIO_free)> memory(::BIO_new(::BIO_s_mem()), &::BIO_free);
  if (!memory || ::PEM_write_bio_X509(memory.get(), certificate.get()) != 1) return "";
  char* text = nullptr;
  const long size = ::BIO_get_mem_data(memory.get(), &text);
  return {text, static_cast<std::size_t>(size)};
}

class TlsStream final : public ByteStream {
public:
  TlsStream(int socket, SSL_CTX& context) : session_(::SSL_new(&context), &::SSL_free) {
    if (!session_ || ::SSL_set_fd(session_.get(), socket) != 1)
      throw std::runtime_error("no memory for a session of TLS");
    ::SSL_set_accept_state(session_.get());
  }

  Transfer handshake() override {
    ::ERR_clear_error();
    return transfer(::SSL_do_handshake(session_.get()), 0);
  }

  Transfer read(char* buffer, std::size_t room) override {
    ::ERR_clear_error();
    std::size_t bytes = 0;
    const int result = ::SSL_read_ex(session_.get(), buffer, room, &bytes);
    return transfer(result, bytes);
  }

  Transfer write(std::string_view data) override {
    ::ERR_clear_error();
    std::size_t bytes = 0;
    const int result = ::SSL_write_ex(session_.get(), data.data(), data.size(), &bytes);
    return transfer(result, bytes);
  }

  void close() override {
    ::ERR_clear_error();
    ::SSL_shutdown(session_.get());
  }

  void describe(Peer& peer) const override {
    const std::string pem = certificate_of(session_.get());
    if (pem.empty()) return;
    const access::Certificate certificate =
        access::read_certificate(pem, "the client's certificate");
    peer.certificate_name = certificate.name;
    peer.certificate_ends_unix = certificate.ends_unix;
  }

private:
  Transfer transfer(int result, std::size_t bytes) const {
    if (result > 0) return {Outcome::moved, bytes};
    switch (::SSL_get_error(session_.get(), result)) {
      case SSL_ERROR_WANT_READ:
        return {Outcome::wait_until_readable};
      case SSL_ERROR_WANT_WRITE:
        return {Outcome::wait_until_writable};
      default:
        return {Outcome::ended};
    }
  }

  const std::unique_ptr<SSL, decltype(&::SSL_free)> session_;
};

}  // namespace

std::unique_ptr<ByteStream> plain_stream(int socket) {
  return std::make_unique<PlainStream>(socket);
}

std::unique_ptr<ByteStream> tls_stream(int socket, SSL_CTX& context) {
  return std::make_unique<TlsStream>(socket, context);
}

}  // namespace dccast::relay
