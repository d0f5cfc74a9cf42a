#pragma once

#include <sys/socket.h>

#include <string>

#include "core/storage/file.hpp"

namespace dccast::relay {

/// A listening TCP or Unix socket. The daemon owns it instead of gRPC for two reasons: an address
/// in use gives one clear line, and gRPC 1.51 accepts connections up to the last file descriptor,
/// which the daemon needs for its jobs.
class Listener {
public:
  /// @param address  host and port, where port 0 chooses a free one; or "unix:" and a path, where a
  ///                 stale socket is replaced
  /// @throws std::runtime_error  the address cannot be used
  explicit Listener(const std::string& address);
  Listener(const Listener&) = delete;
  /// Closes the socket and removes its path.
  ~Listener();

  /// Host and port in use, or "unix:" and the path.
  const std::string& address() const { return address_; }
  /// Descriptor, which stays owned.
  int socket() const { return socket_.get(); }

private:
  /// Replaces a stale socket; refuses one on which a daemon still listens.
  void listen_at_path(const std::string& path);
  /// Resolves the address and listens.
  void listen_on_port(const std::string& address);

  storage::FileDescriptor socket_;
  std::string address_;
};

/// Host of an address from accept(): "192.0.2.1"; "unix" for a Unix socket.
std::string host_of(const sockaddr_storage& address, socklen_t size);
/// Address in gRPC's notation: "ipv4:192.0.2.1:40000", "ipv6:%5B::1%5D:40000", "unix:".
std::string uri_of(const std::string& host, const sockaddr_storage& address);

}  // namespace dccast::relay
