#pragma once

#include <openssl/ssl.h>

#include <cstddef>
#include <memory>
#include <string_view>

#include "server/relay/peer_table.hpp"

namespace dccast::relay {

/// Outcome of one attempt to move bytes over a socket that does not block.
struct Transfer {
  enum class Outcome {
    moved,
    wait_until_readable,  ///< try again once the socket can be read
    wait_until_writable,  ///< try again once the socket can be written
    ended,                ///< by the other side, or an error
  };
  Outcome outcome = Outcome::moved;
  std::size_t bytes = 0;  ///< where `moved`
};

/// One end of a connection, over a socket that does not block and outlives this object.
class ByteStream {
public:
  virtual ~ByteStream() = default;

  /// Called until it has moved; `bytes` says nothing.
  virtual Transfer handshake() = 0;
  virtual Transfer read(char* buffer, std::size_t room) = 0;
  /// May write less than all. What was not written must be tried again first.
  virtual Transfer write(std::string_view bytes) = 0;
  /// Tells the other side that nothing more comes.
  virtual void close() = 0;
  /// Adds what the handshake has shown.
  virtual void describe(Peer& peer) const = 0;
};

/// Bytes as they are.
std::unique_ptr<ByteStream> plain_stream(int socket);

/// The server's side of TLS. @throws std::runtime_error  OpenSSL has no memory for it
std::unique_ptr<ByteStream> tls_stream(int socket, SSL_CTX& context);

}  // namespace dccast::relay
