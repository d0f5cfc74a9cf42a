#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "client/session/connection.hpp"

namespace dccast::client {

/// Connections to the daemon of this machine for the users whose tokens they carry: one for each
/// token and address, so that no user waits behind another. The one that was not used for the
/// longest time gives way; what is under way over it goes on. Safe to use from several threads.
class UserChannels {
public:
  static constexpr std::size_t most_kept = 256;

  /// @param server  "unix:" and the path of the daemon's socket
  explicit UserChannels(std::string server) : server_(std::move(server)) {}

  /// @param token  of the user; empty for a call that needs none
  /// @param address  of the browser, "192.0.2.7", for the daemon's limits and audit log
  Connection connection(const std::string& token, const std::string& address);

private:
  struct Kept {
    Connection connection;
    std::uint64_t used;  ///< larger: later
  };

  const std::string server_;
  std::mutex mutex_;
  std::uint64_t uses_ = 0;
  std::map<std::pair<std::string, std::string>, Kept> kept_;
};

}  // namespace dccast::client
