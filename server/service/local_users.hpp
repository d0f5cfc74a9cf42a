#pragma once

#include <map>
#include <mutex>
#include <string>

namespace dccast::service {

/// Names of the users of this machine who call over loopback. The system knows whose socket the
/// other end of a connection is. Safe to use from several threads.
class LocalUsers {
public:
  /// @param address  where we listen: "127.0.0.1:7117", "[::1]:7117"
  explicit LocalUsers(std::string address) : address_(std::move(address)) {}

  /// @param peer  as gRPC writes it: "ipv4:127.0.0.1:40000", "ipv6:%5B::1%5D:40000"
  /// @return      a name, or the number of a user without one; empty when the system does not know
  std::string name_of(const std::string& peer);

private:
  const std::string address_;
  std::mutex mutex_;
  std::map<unsigned, std::string> names_;  ///< by user id
};

}  // namespace dccast::service
