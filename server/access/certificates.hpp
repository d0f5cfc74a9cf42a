#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace dccast::access {

/// What a certificate states.
struct Certificate {
  std::string name;                             ///< common name of its subject
  std::vector<std::string> names;               ///< host names and addresses it is good for
  std::int64_t begins_unix = 0, ends_unix = 0;  ///< [s since 1970]
  std::string sha256;  ///< fingerprint: of its DER form, 64 hexadecimal digits
};

/// The first certificate of a PEM text. @throws Refused  there is none
Certificate read_certificate(const std::string& pem, const std::string& where);

/// A CA of our own with the certificates it issued: folder pki of the data directory, its owner's
/// alone. Keys are EC P-256. All calls throw storage::StorageError or Refused.
class Pki {
public:
  explicit Pki(const std::filesystem::path& directory) : directory_(directory / "pki") {}

  std::filesystem::path ca() const { return directory_ / "ca.pem"; }
  std::filesystem::path server() const { return directory_ / "server.pem"; }
  std::filesystem::path server_key() const { return directory_ / "server.key"; }
  bool exists() const;

  /// Makes the CA, for ten years. @throws Refused  there is one: all clients would have to log in
  /// again
  void init() const;
  /// A certificate for the server, for so many days; key first, both replaced whole, so that the
  /// daemon that watches the files never takes up half of the pair for long.
  /// @param names  host names and IP addresses
  void issue_server(const std::vector<std::string>& names, int days) const;
  /// A certificate for a user whom the server lists: user.pem and user.key in `directory`.
  void issue_user(const std::string& user, int days, const std::filesystem::path& directory) const;

private:
  std::filesystem::path ca_key() const { return directory_ / "ca.key"; }

  const std::filesystem::path directory_;
};

/// The name of this machine, its addresses and loopback: what clients may call it.
std::vector<std::string> names_of_this_machine();

}  // namespace dccast::access
