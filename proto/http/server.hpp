#pragma once

#include <openssl/ossl_typ.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "proto/http/message.hpp"

namespace dccast::http {

/// The address is taken, or is none of this machine.
struct CannotListen : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// The files are not a certificate and its key.
struct BadCertificate : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What peers may cost. A connection that waits longer for its peer than `time` is closed.
struct Limits {
  std::size_t header_bytes = 8192;  ///< request line and all headers
  std::size_t body_bytes = 0;       ///< of a request; those of long bodies come at 64 KiB/s or more
  std::size_t upload_bytes = 0;     ///< of the body of a PUT; 0: there is none
  std::size_t all_bodies_bytes = 64 << 20;  ///< of all requests that are read or answered
  std::size_t connections = 256;            ///< at once
  std::size_t connections_of_address = 32;  ///< a stream that would be one more is refused
  std::size_t handlers = 4;                 ///< requests that are answered at once; others wait
  std::chrono::milliseconds time{5000};     ///< for a handshake, a header, a part of a reply
};

/// Whether a value of the header Host is a name of this server: another site may point a name of
/// its own at this address, and a browser then takes both for one.
using IsOwnHost = std::function<bool(const std::string& host)>;

/// A small server of HTTP/1.1, or HTTPS, within limits that hold for peers that were never let in.
/// One thread serves all connections, a few others run the handlers. When all connections, or those
/// of an address, are taken, the oldest one that waits for its peer makes room, else the oldest one
/// after its answer.
class Server {
public:
  /// Where the server listens.
  struct Listening {
    std::string host{};                ///< name or address of this machine
    int port = 0;                      ///< 0: any free one
    std::string socket{};              ///< path of a Unix socket in their place; empty: none
    std::string certificate{}, key{};  ///< PEM files, for HTTPS; empty: HTTP
    /// Called when the files of the certificate have changed: new connections have the new one.
    /// @param fault  why they cannot be used; the former one then stays
    std::function<void(const std::string& fault)> when_renewed = [](const std::string&) {};
  };

  /// Takes the address; connections wait until start(). A Unix socket is for user and group of
  /// this process. @throws CannotListen, BadCertificate
  Server(const Listening& listening, const Limits& limits);
  /// Closes all connections and waits for the handlers that are at work.
  ~Server();
  Server(const Server&) = delete;

  /// Port in use, also where a free one was asked for. 0: it is a Unix socket.
  int port() const;
  /// The one of new connections; null for HTTP. From any thread.
  std::shared_ptr<const X509> certificate() const;

  /// Begins to answer. To be called once.
  void start(IsOwnHost is_own_host, Handler handler);
  /// Closes all connections, and takes no more.
  void stop();

private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace dccast::http
