#pragma once

#include <openssl/ssl.h>

#include <cstddef>
#include <memory>
#include <string_view>

#include "server/relay/peer_table.hpp"
#include "server/relay/turn_budget.hpp"

namespace dccast::relay {

/// Outcome of one attempt to move bytes over a socket that does not block.
struct Transfer {
  enum class Outcome {
    moved,
    wait_until_readable,  ///< try again once the socket can be read
    wait_until_writable,  ///< try again once the socket can be written
    turn_is_over,         ///< try again in the next turn: the budget of this one is spent
    ended,                ///< the other side closed, or an error
  };
  Outcome outcome = Outcome::moved;
  std::size_t bytes = 0;          ///< set if `moved`
  std::string_view hostile = {};  ///< set if `ended` for what the other side sent: what that was
};

/// One end of a connection, over a non-blocking socket that outlives this object. Its transfers
/// spend the budget of a turn.
class ByteStream {
public:
  virtual ~ByteStream() = default;

  /// Repeat until the outcome is `moved`; `bytes` is not set.
  virtual Transfer handshake() = 0;
  /// Reads what there is. @param room  size of the buffer [bytes]
  virtual Transfer read(char* buffer, std::size_t room) = 0;
  /// May write only a part. The rest must be written before anything else.
  virtual Transfer write(std::string_view bytes) = 0;
  /// Informs the other side that nothing more follows.
  virtual void close() = 0;
  /// Adds to `peer` what the handshake has established.
  virtual void describe(Peer& peer) const = 0;
};

/// Stream without encryption. @param turn  outlives the stream
std::unique_ptr<ByteStream> plain_stream(int socket, TurnBudget& turn);

/// Server side of TLS. Ends a connection whose records carry no content: handshakes in small
/// pieces, renewed keys, alerts, empty records.
/// @param turn  outlives the stream
/// @throws std::runtime_error  OpenSSL is out of memory
std::unique_ptr<ByteStream> tls_stream(int socket, SSL_CTX& context, TurnBudget& turn);

}  // namespace dccast::relay
