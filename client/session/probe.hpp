#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "client/session/connection.hpp"

namespace dccast::client {

struct ProbeOptions {
  std::chrono::milliseconds timeout{5000};  ///< of each step on the wire
  std::string role{};                       ///< that the user is to have; empty: any
  std::string version;                      ///< of this client
};

/// Why calls to a server fail, step by step: address, name, port, TLS, certificate, and last a call
/// with the token. Uses sockets and OpenSSL, as gRPC states no more than that a connection failed.
/// "ssh://...": whether ssh reaches the machine, whether the port there takes connections, a call.
/// @param found  a line for each step that succeeded is added
Diagnosis diagnose(const Endpoint& endpoint, const ProbeOptions& options,
                   std::vector<std::string>& found, std::shared_ptr<Interruption> interruption);

/// The certificate with this fingerprint among those a server shows, as PEM: the CA that a login
/// trusts from then on. Throws CommandFailed with the diagnosis if there is none.
/// @param fingerprint  SHA-256 of its DER form, 64 hexadecimal digits
std::string certificate_with_fingerprint(const std::string& address, const std::string& fingerprint,
                                         const ProbeOptions& options);

}  // namespace dccast::client
