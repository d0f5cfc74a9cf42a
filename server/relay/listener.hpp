#pragma once

#include <sys/socket.h>

#include <string>

#include "core/storage/file.hpp"

namespace dccast::relay {

/// A TCP socket that listens. It is our own and not gRPC's: an address that is taken gives one line
/// with its reason, and gRPC 1.51 accepts whatever comes, up to the last file descriptor, which the
/// daemon would lack for its jobs.
class Listener {
public:
  /// @param address  host and port; port 0 takes a free one
  /// @throws std::runtime_error  it cannot listen there
  explicit Listener(const std::string& address);

  /// Host and port in use.
  const std::string& address() const { return address_; }
  int socket() const { return socket_.get(); }

private:
  storage::FileDescriptor socket_;
  std::string address_;
};

/// The host of an address that accept() gave: "192.0.2.1".
std::string host_of(const sockaddr_storage& address, socklen_t size);
/// As gRPC writes it: "ipv4:192.0.2.1:40000", "ipv6:%5B::1%5D:40000".
std::string uri_of(const std::string& host, const sockaddr_storage& address);

}  // namespace dccast::relay
