#pragma once

#include <string>

#include "core/storage/file.hpp"

namespace dccast::service {

/// Whether clients on other machines cannot reach this address ("127.0.0.1:0", "[::1]:7117",
/// "localhost:7117").
bool is_loopback(const std::string& address);

/// A TCP socket that listens. It is our own and not gRPC's: an address that is taken gives one line
/// with its reason, and connections can be counted.
class ListeningSocket {
public:
  /// @param address  host and port; port 0 takes a free one
  /// @throws std::runtime_error  it cannot listen there
  explicit ListeningSocket(const std::string& address);
  int descriptor() const { return socket_.get(); }
  /// Host and port in use.
  const std::string& address() const { return address_; }

private:
  storage::FileDescriptor socket_;
  std::string address_;
};

}  // namespace dccast::service
