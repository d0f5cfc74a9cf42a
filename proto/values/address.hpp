#pragma once

#include <charconv>
#include <optional>
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

/// The port of an address, 0 to 65535; empty: it has none, or another text in its place. gRPC and
/// the system would take a larger one modulo 65536.
inline std::optional<int> port_of(const std::string& address) {
  const std::string text = host_and_port(address).port;
  int port = -1;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, port);
  const bool is_port = error == std::errc() && rest == end && port >= 0 && port <= 65535;
  return is_port ? std::optional(port) : std::nullopt;
}

/// Whether this is an address as the header Origin has it: https://NAME or https://NAME:PORT.
inline bool is_web_origin(const std::string& text) {
  constexpr const char* scheme = "https://";
  if (!text.starts_with(scheme)) return false;
  const std::string address = text.substr(std::string(scheme).size());
  const HostAndPort parts = host_and_port(address);
  const bool is_ip_v6 = address.starts_with('[');
  const char* const permitted = is_ip_v6 ? "0123456789abcdefABCDEF:."
                                         : "0123456789abcdefghijklmnopqrstuvwxyz"
                                           "ABCDEFGHIJKLMNOPQRSTUVWXYZ-.";
  return !parts.host.empty() && parts.host.find_first_not_of(permitted) == std::string::npos &&
         (parts.host.size() + (is_ip_v6 ? 2 : 0) == address.size() || port_of(address));
}

/// Whether other machines cannot reach this address ("127.0.0.1:0", "[::1]:7117",
/// "localhost:7117"). Names that merely begin like a loopback address ("127.example") do not count.
inline bool is_loopback(const std::string& address) {
  const std::string host = host_and_port(address).host;
  return host == "localhost" || host == "::1" ||
         (host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos);
}

}  // namespace dccast::values
