#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "client/session/connection.hpp"

/// The servers of a user: logins to them, and why calls to one fail.
namespace dccast::client {

/// A server that `dccast login` has stored.
struct StoredServer {
  std::string name;  ///< unique, as in --server NAME
  Endpoint endpoint;
  /// Name that the server gave at login.
  std::string user;
  std::string expires{};  ///< end of the token [s since 1970]; empty: not known
  /// Whether the token ends within fourteen days.
  bool ends_soon() const;
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
  /// Forgets a server and rewrites the file.
  void remove(const std::string& name);

private:
  /// Replaces the file as a whole. Throws CommandFailed.
  void write() const;

  std::filesystem::path file_;
  std::vector<StoredServer> all_;
};

/// Where an address points without a stored server: a Unix socket of this machine. Throws
/// CommandFailed for any other, which needs a login.
Endpoint endpoint_of(const std::string& server);

/// The line that `dccastd user add` prints: "HOST:PORT/sha256:FINGERPRINT/SECRET".
struct EnrolmentLine {
  /// HOST:PORT; 64 hexadecimal digits of SHA-256; good for one login.
  std::string address, fingerprint, secret;
};
/// Throws CommandFailed for any other text.
EnrolmentLine read_enrolment_line(const std::string& text);

/// Makes the login that the line permits: compares the fingerprint of the server's CA before
/// anything is sent, and buys a token. Throws CommandFailed.
StoredServer log_in(const EnrolmentLine& line, const std::string& name,
                    std::shared_ptr<Interruption> interruption);

/// Exchanges the token of a server for a new one with its full life. The old one is good until it
/// is revoked. Throws CommandFailed.
void renew_token(StoredServer& server, std::shared_ptr<Interruption> interruption);

/// "2026-11-20 14:03Z".
std::string utc_text(std::int64_t unix_s);

/// Name of a role, as `dccastd user` takes it.
std::string role_text(v1::Role role);

/// What diagnose() tries, and for how long.
struct ProbeOptions {
  std::chrono::milliseconds timeout{5000};  ///< of each step on the wire
  std::string role{};                       ///< that the user is to have; empty: any
  std::string version;                      ///< of this client
};

/// Why calls to a server fail, step by step: address, name, port, TLS, certificate, and last a call
/// with the token. Uses sockets and OpenSSL, as gRPC states no more than that a connection failed.
/// "ssh://...": whether ssh reaches the machine, whether the socket there takes connections, a
/// call.
/// @param found  a line for each step that succeeded is added
Diagnosis diagnose(const Endpoint& endpoint, const ProbeOptions& options,
                   std::vector<std::string>& found, std::shared_ptr<Interruption> interruption);

/// The certificate with this fingerprint among those a server shows, as PEM: the CA that a login
/// trusts from then on. Throws CommandFailed with the diagnosis if there is none.
/// @param fingerprint  SHA-256 of its DER form, 64 hexadecimal digits
std::string certificate_with_fingerprint(const std::string& address, const std::string& fingerprint,
                                         const ProbeOptions& options);

}  // namespace dccast::client
