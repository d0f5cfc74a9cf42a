#include "server/relay/byte_stream.hpp"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <sys/socket.h>

#include <cerrno>
#include <stdexcept>
#include <string>

#include "server/access/certificates.hpp"
#include "server/access/limits.hpp"

namespace dccast::relay {

namespace {

using Outcome = Transfer::Outcome;

class PlainStream final : public ByteStream {
public:
  PlainStream(int socket, TurnBudget& turn) : socket_(socket), turn_(turn) {}

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
  Transfer transfer(ssize_t moved, Outcome otherwise) {
    if (moved < 0 && (errno == EAGAIN || errno == EINTR)) return {otherwise};
    if (moved <= 0) return {Outcome::ended};
    const auto bytes = static_cast<std::size_t>(moved);
    turn_.spend(bytes);
    return {Outcome::moved, bytes};
  }

  const int socket_;
  TurnBudget& turn_;
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

/// Counts the records of a peer that carry no content. A handshake has some ten of them; then a
/// peer renews its keys once in gigabytes.
class RecordGuard {
public:
  /// Receives the head of each record.
  void on_record() {
    if (in_handshake_) {
      ++of_handshake_;
      return;
    }
    if (lacks_content_ && !empty_.take(TurnBudget::Clock::now())) sends_nothing_ = true;
    lacks_content_ = true;
  }
  void on_content() { lacks_content_ = false; }
  void on_end_of_handshake() { in_handshake_ = false; }

  /// Reason to end the connection; empty if there is none.
  std::string_view fault() const {
    if (of_handshake_ > most_of_handshake) return "it sends its handshake in small pieces";
    return sends_nothing_ ? "it renews keys or sends records without content" : "";
  }

private:
  static constexpr int most_of_handshake = 128;

  access::Allowance empty_{1.0, 32.0};
  int of_handshake_ = 0;
  bool in_handshake_ = true, lacks_content_ = false, sends_nothing_ = false;
};

class TlsStream final : public ByteStream {
public:
  TlsStream(int socket, SSL_CTX& context, TurnBudget& turn)
      : turn_(turn), session_(::SSL_new(&context), &::SSL_free) {
    if (!session_ || ::SSL_set_fd(session_.get(), socket) != 1)
      throw std::runtime_error("no memory for a session of TLS");
    ::SSL_set_accept_state(session_.get());

    // OpenSSL reads on as long as records bring no content: the socket stops it.
    BIO* const bytes = ::SSL_get_rbio(session_.get());
    ::BIO_set_callback_arg(bytes, reinterpret_cast<char*>(this));
    ::BIO_set_callback_ex(bytes, &TlsStream::on_transfer);
    ::SSL_set_msg_callback_arg(session_.get(), this);
    ::SSL_set_msg_callback(session_.get(), &TlsStream::on_message);
  }

  Transfer handshake() override {
    ::ERR_clear_error();
    const Transfer step = transfer(::SSL_do_handshake(session_.get()), 0);
    if (step.outcome == Outcome::moved) records_.on_end_of_handshake();
    return step;
  }

  Transfer read(char* buffer, std::size_t room) override {
    ::ERR_clear_error();
    std::size_t bytes = 0;
    const int result = ::SSL_read_ex(session_.get(), buffer, room, &bytes);
    if (result > 0) records_.on_content();
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
  /// Before and after each read and write of the socket. @return what the caller receives
  static long on_transfer(BIO* socket, int operation, const char*, std::size_t, int, long,
                          int result, std::size_t* bytes) {
    auto& self = *reinterpret_cast<TlsStream*>(::BIO_get_callback_arg(socket));
    if (operation == BIO_CB_READ && self.must_pause()) {
      BIO_clear_retry_flags(socket);
      BIO_set_retry_read(socket);
      return -1;
    }

    const bool has_moved =
        operation == (BIO_CB_READ | BIO_CB_RETURN) || operation == (BIO_CB_WRITE | BIO_CB_RETURN);
    if (has_moved && result > 0) self.turn_.spend(*bytes);
    return result;
  }

  /// Each head of a record and each message of TLS, sent and received.
  static void on_message(int is_sent, int, int kind, const void*, std::size_t, SSL*, void* self) {
    if (is_sent == 0 && kind == SSL3_RT_HEADER) static_cast<TlsStream*>(self)->records_.on_record();
  }

  /// Whether nothing more is read from the socket in this turn.
  bool must_pause() const {
    return !records_.fault().empty() || turn_.is_spent(TurnBudget::Clock::now());
  }

  Transfer transfer(int result, std::size_t bytes) const {
    if (const auto fault = records_.fault(); !fault.empty())
      return {.outcome = Outcome::ended, .hostile = fault};
    if (result > 0) return {Outcome::moved, bytes};
    switch (::SSL_get_error(session_.get(), result)) {
      case SSL_ERROR_WANT_READ:
        if (turn_.is_spent(TurnBudget::Clock::now())) return {Outcome::turn_is_over};
        return {Outcome::wait_until_readable};
      case SSL_ERROR_WANT_WRITE:
        return {Outcome::wait_until_writable};
      default:
        return {Outcome::ended};
    }
  }

  TurnBudget& turn_;
  RecordGuard records_;
  const std::unique_ptr<SSL, decltype(&::SSL_free)> session_;
};

}  // namespace

std::unique_ptr<ByteStream> plain_stream(int socket, TurnBudget& turn) {
  return std::make_unique<PlainStream>(socket, turn);
}

std::unique_ptr<ByteStream> tls_stream(int socket, SSL_CTX& context, TurnBudget& turn) {
  return std::make_unique<TlsStream>(socket, context, turn);
}

}  // namespace dccast::relay
