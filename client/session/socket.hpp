#pragma once

#include <openssl/ssl.h>

#include <chrono>
#include <string>

#include "proto/values/address.hpp"
#include "proto/values/owned.hpp"

/// What is on the wire to a server: a connection without gRPC, and what is spoken there.
namespace dccast::client {

/// Host name, for messages.
std::string host_name();

/// A TCP connection with a time limit for each step. Neither gRPC nor a proxy is involved.
class Socket {
public:
  /// How far a connection came: to the name, to the machine, or to the port.
  enum class Outcome { connected, no_name, refused, timed_out, no_route, failed };

  /// Connects, trying the addresses of the name in turn. @param timeout  for each address
  Socket(const values::HostAndPort& to, std::chrono::milliseconds timeout);
  Socket(const Socket&) = delete;
  ~Socket();

  bool is_connected() const { return descriptor_ >= 0; }
  Outcome outcome() const { return outcome_; }
  const std::string& reason() const { return reason_; }  ///< the system's words; empty if connected
  /// What arrives within the time limit, up to 64 bytes, after `sent` was sent.
  std::string exchange(const std::string& sent);
  /// -1 unless connected; stays owned.
  int descriptor() const { return descriptor_; }

private:
  int descriptor_ = -1;
  Outcome outcome_ = Outcome::connected;
  std::string reason_;
};

/// The greeting of HTTP/2.
extern const std::string http2_greeting;

/// What answers at a port, by its first bytes.
enum class Speaks { http2, tls, http1, nothing, something_else };

/// What a server answers to the greeting without TLS.
Speaks language_of(const std::string& answer);

/// A TLS handshake over a connected socket. Verification does not end it: what it found is asked
/// after.
struct Handshake {
  /// @param ca  PEM, trusted alone; empty: none is
  Handshake(const Socket& socket, const values::HostAndPort& to, const std::string& ca);

  /// OpenSSL's objects for one handshake.
  values::Owned<SSL_CTX, SSL_CTX_free> context;
  values::Owned<SSL, SSL_free> session;
  /// Whether the handshake has succeeded.
  bool made = false;
};

}  // namespace dccast::client
