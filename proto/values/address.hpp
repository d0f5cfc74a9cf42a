#pragma once

#include <string>

namespace dccast::values {

/// "casthouse:7118" or "[::1]:7118" in its parts; the port may be empty.
struct HostAndPort {
  std::string host;  ///< without brackets
  std::string port;
};
HostAndPort host_and_port(const std::string& address);

/// Whether other machines cannot reach this address ("127.0.0.1:0", "[::1]:7117",
/// "localhost:7117"). A name that only begins as a number of loopback does, is none.
bool is_loopback(const std::string& address);

}  // namespace dccast::values
