#pragma once

#include <string>

namespace dccast::values {

/// The parts of an address such as "casthouse:7118" or "[::1]:7118".
struct HostAndPort {
  std::string host;  ///< without brackets
  std::string port;  ///< may be empty
};

/// Splits at the last colon; an IPv6 address stands in brackets.
inline HostAndPort host_and_port(const std::string& address) {
  const auto colon = address.rfind(':');
  const bool has_port = colon != std::string::npos && address.find(']', colon) == std::string::npos;

  HostAndPort parts{address.substr(0, has_port ? colon : std::string::npos),
                    has_port ? address.substr(colon + 1) : ""};
  if (parts.host.starts_with('[') && parts.host.ends_with(']'))
    parts.host = parts.host.substr(1, parts.host.size() - 2);
  return parts;
}

/// Whether other machines cannot reach this address ("127.0.0.1:0", "[::1]:7117",
/// "localhost:7117"). Names that merely begin like a loopback address ("127.example") do not count.
inline bool is_loopback(const std::string& address) {
  const std::string host = host_and_port(address).host;
  return host == "localhost" || host == "::1" ||
         (host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos);
}

}  // namespace dccast::values
