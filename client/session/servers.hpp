#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/session/connection.hpp"

namespace dccast::client {

/// A server that `dccast login` has stored.
struct StoredServer {
  std::string name;  ///< unique, as in --server NAME
  Endpoint endpoint;
  std::string user;
};

/// The servers of a user in servers.toml beside the settings: mode 0600, as their tokens are in it.
/// The first is the default. Throws CommandFailed for a file that cannot be read or written.
class StoredServers {
public:
  /// @param file  empty: none are stored. A missing file is no error.
  explicit StoredServers(std::filesystem::path file);

  const std::vector<StoredServer>& all() const { return all_; }
  /// @param text  a name, or an address with or without port; empty: the default
  /// @return nothing if none is meant
  const StoredServer* find(const std::string& text) const;
  /// Adds a server, or replaces the one with its name; as the first if it is to be the default.
  void store(const StoredServer& server, bool first);
  void remove(const std::string& name);

private:
  void write() const;

  std::filesystem::path file_;
  std::vector<StoredServer> all_;
};

/// Where an address points without a stored server: on loopback, without TLS. Throws CommandFailed
/// for any other, which needs a login.
Endpoint endpoint_of(const std::string& server);

/// The line that `dccastd user add` prints: "HOST:PORT/sha256:FINGERPRINT/SECRET".
struct EnrolmentLine {
  std::string address, fingerprint, secret;
};
/// Throws CommandFailed for any other text.
EnrolmentLine read_enrolment_line(const std::string& text);

/// Makes the login that the line permits: compares the fingerprint of the server's CA before
/// anything is sent, and buys a token. Throws CommandFailed.
StoredServer log_in(const EnrolmentLine& line, const std::string& name,
                    std::shared_ptr<Interruption> interruption);

}  // namespace dccast::client
