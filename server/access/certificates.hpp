#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace dccast::access {

/// What a certificate states.
struct Certificate {
  std::string name;                ///< common name of its subject
  std::vector<std::string> names;  ///< host names and addresses for which it is valid
  std::int64_t begins_unix = 0;    ///< [s since 1970]
  std::int64_t ends_unix = 0;      ///< [s since 1970]
  std::string sha256;              ///< fingerprint: of its DER form, 64 hexadecimal digits
};

/// The first certificate of a PEM text. @throws Refused  there is none
Certificate read_certificate(const std::string& pem, const std::string& where);

/// Why a client that trusts this CA does not trust the certificates of a PEM text; empty: it does.
std::string signature_fault(const std::string& pem, const std::string& ca_pem);
/// Whether the certificate is for this host name or address.
bool is_for(const std::string& pem, const std::string& host);

/// The daemon's own CA and the certificates it issues, in the folder pki of the data directory;
/// only its owner can read them. Keys are EC P-256. All calls throw storage::StorageError or
/// Refused.
class Pki {
public:
  explicit Pki(const std::filesystem::path& directory) : directory_(directory / "pki") {}

  std::filesystem::path ca() const { return directory_ / "ca.pem"; }
  std::filesystem::path server() const { return directory_ / "server.pem"; }
  std::filesystem::path server_key() const { return directory_ / "server.key"; }
  bool exists() const;

  /// Creates the CA, valid for ten years.
  /// @throws Refused  it exists: all clients would have to log in again
  void init() const;
  /// Issues a certificate for the server. The key is replaced first and each file as a whole, so
  /// that the daemon, which watches the files, uses a mismatched pair only for a moment.
  /// @param names  host names and IP addresses
  void issue_server(const std::vector<std::string>& names, int days) const;
  /// Issues a certificate for a user whom the server lists: user.pem and user.key in `directory`.
  void issue_user(const std::string& user, int days, const std::filesystem::path& directory) const;

private:
  std::filesystem::path ca_key() const { return directory_ / "ca.key"; }

  const std::filesystem::path directory_;
};

}  // namespace dccast::access
