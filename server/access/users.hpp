#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>

#include "dccast/v1/access.pb.h"
#include "proto/refusal/refusal.hpp"

namespace dccast::access {

/// A change that cannot be made; the text is a sentence with the remedy.
class Refused : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// How the identity of a caller was proved.
enum class ProvenBy { local_user, token, certificate };
std::string text_of(ProvenBy proof);

struct Caller {
  std::string name{};  ///< empty if the system does not know the local user
  v1::Role role = v1::ROLE_UNSPECIFIED;
  ProvenBy by = ProvenBy::local_user;
  std::string credential{};                 ///< id of the token
  std::int64_t expires_unix = 0;            ///< of token or certificate [s since 1970]; 0: never
  std::optional<refusal::Facts> refusal{};  ///< why the identity was not proved

  bool proven() const { return !refusal; }
};

/// Users of other machines, with salted digests of their secrets, in users.toml of the data
/// directory; only its owner can read the file. Commands change it while the daemon reads it: a
/// change locks users.lock and replaces the file, and each read checks whether it was replaced.
/// Safe to use from several threads. Every call throws storage::StorageError if the file cannot be
/// read or written, and Refused if it is damaged.
class UserStore {
public:
  /// @param directory  the data directory
  explicit UserStore(const std::filesystem::path& directory);

  /// Adds a user. Secrets are 256 random bits with a public id; only SHA-256(salt, secret) is
  /// stored. Times are in seconds since 1970. @return a one-time secret for enrol() @throws Refused
  std::string add(const std::string& name, v1::Role role, std::int64_t now, std::int64_t expires);
  /// Revokes all credentials of a user, and makes a new one-time secret. @throws Refused  no such
  /// user
  std::string rotate(const std::string& name, std::int64_t now, std::int64_t expires);
  /// Makes a one-time secret for a further token; revokes nothing. @param token  name of the token;
  /// empty: that of the machine where it is fetched @throws Refused  no such user
  std::string add_line(const std::string& name, const std::string& token, std::int64_t now,
                       std::int64_t expires);
  void remove(const std::string& name);
  void set_disabled(const std::string& name, bool disabled);
  void set_role(const std::string& name, v1::Role role);
  /// Revokes a token or one-time secret. @return whether it existed
  bool revoke(const std::string& name, const std::string& credential);

  /// Exchanges a one-time secret for a token, or a token for another one of the same name, beside
  /// which it stays good until its client revokes it. @param machine  free text, stored with the
  /// token
  /// @param token  set if the secret is valid
  Caller enrol(const std::string& secret, const std::string& machine, std::int64_t now,
               std::int64_t token_expires, std::string& token);
  Caller prove(const std::string& token, std::int64_t now);

  v1::Users users();
  /// @return nothing if the name is not listed
  std::optional<v1::User> find(const std::string& name);

private:
  /// Identifies a version of the file.
  struct FileVersion {
    std::uint64_t inode = 0;
    std::int64_t modified_ns = 0, size = -1;
    bool operator==(const FileVersion&) const = default;
  };
  void change(const std::function<void(v1::Users& users)>& edit);
  void refresh();
  void read();
  FileVersion version() const;

  const std::filesystem::path file_, lock_;
  std::mutex mutex_;  ///< guards all below
  v1::Users users_;
  FileVersion read_version_;
};

/// The link that signs in with a one-time secret. It stands behind '#', which browsers do not send.
/// @param web  address of dccast-web
std::string sign_in_link(const std::string& web, const std::string& secret);

/// "viewer", "submitter" or "admin". @throws Refused for another text
v1::Role parse_role(const std::string& text);
std::string text_of(v1::Role role);
/// Why an identity is not proved.
refusal::Facts not_proven(std::string cause, std::string remedy);
/// The same of a disabled user.
refusal::Facts disabled(const std::string& name);

}  // namespace dccast::access
