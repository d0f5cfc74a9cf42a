#pragma once

#include <chrono>
#include <string>

#include "proto/values/address.hpp"

namespace dccast::client {

std::string name_of_this_machine();

/// A TCP connection with a time limit for each step. Neither gRPC nor a proxy is involved.
class Socket {
public:
  enum class Outcome { connected, no_name, refused, timed_out, no_route, failed };

  Socket() = default;
  Socket(const Socket&) = delete;
  ~Socket();

  /// @param reason  is set to the system's words if it is not connected
  Outcome connect(const values::HostAndPort& to, std::chrono::milliseconds timeout,
                  std::string& reason);
  /// What arrives within the time limit, up to 64 bytes, after `sent` was sent.
  std::string exchange(const std::string& sent);
  int descriptor() const { return descriptor_; }

private:
  int descriptor_ = -1;
};

}  // namespace dccast::client
