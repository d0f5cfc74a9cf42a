#pragma once

#include <sys/socket.h>

#include <string>

#include "core/storage/file.hpp"

namespace dccast::relay {

/// A socket that listens, of TCP or of Unix. It is our own and not gRPC's: an address that is taken
/// gives one line with its reason, and gRPC 1.51 accepts whatever comes, up to the last file
/// descriptor, which the daemon would lack for its jobs.
class Listener {
public:
  /// @param address  host and port, of which 0 takes a free one; or "unix:" and a path, where a
  ///                 socket that no one listens to is replaced
  /// @throws std::runtime_error  it cannot listen there
  explicit Listener(const std::string& address);
  Listener(const Listener&) = delete;
  ~Listener();

  /// Host and port in use, or "unix:" and the path.
  const std::string& address() const { return address_; }
  int socket() const { return socket_.get(); }

private:
  void listen_at_path(const std::string& path);
  void listen_on_port(const std::string& address);

  storage::FileDescriptor socket_;
  std::string address_;
};

/// The host of an address that accept() gave: "192.0.2.1"; "unix" for a Unix socket.
std::string host_of(const sockaddr_storage& address, socklen_t size);
/// As gRPC writes it: "ipv4:192.0.2.1:40000", "ipv6:%5B::1%5D:40000", "unix:".
std::string uri_of(const std::string& host, const sockaddr_storage& address);

}  // namespace dccast::relay
