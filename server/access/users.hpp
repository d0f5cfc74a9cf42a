#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>

#include "dccast/v1/access.pb.h"

namespace dccast::access {

/// A change of the users that cannot be made; the text is a sentence with the remedy.
class Refused : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// How it is known who calls.
enum class ProvenBy { local_user, token, certificate };
std::string text_of(ProvenBy proof);

struct Caller {
  std::string name{};  ///< empty where the system does not know the local user
  v1::Role role = v1::ROLE_UNSPECIFIED;
  ProvenBy by = ProvenBy::local_user;
  std::string credential{};       ///< id of the token
  std::int64_t expires_unix = 0;  ///< of token or certificate [s since 1970]; 0: never
  std::string refusal{};          ///< why no one was proved: a sentence with the remedy

  bool proven() const { return refusal.empty(); }
};

/// The users of other machines with what is kept of their secrets: users.toml of the data
/// directory, its owner's alone. Commands change it while the daemon reads it: a change holds
/// users.lock and replaces the file, and each read looks whether it was replaced. Safe to use from
/// several threads. Every call throws storage::StorageError where the file cannot be read or
/// written, and Refused where it is damaged.
class UserStore {
public:
  /// @param directory  the data directory
  explicit UserStore(const std::filesystem::path& directory);

  /// All secrets are 256 random bits, named by a public id; only SHA-256(salt, secret) is kept.
  /// Times are in seconds since 1970. @return a one-time secret for enrol() @throws Refused
  std::string add(const std::string& name, v1::Role role, std::int64_t now, std::int64_t expires);
  /// Revokes what the user has, and makes a new one-time secret. @throws Refused  no such user
  std::string rotate(const std::string& name, std::int64_t now, std::int64_t expires);
  void remove(const std::string& name);
  void set_disabled(const std::string& name, bool disabled);
  void set_role(const std::string& name, v1::Role role);
  /// Takes a token or one-time secret back. @return whether it was there
  bool revoke(const std::string& name, const std::string& credential);

  /// Buys a token with a one-time secret. @param machine  free text, kept beside the token
  /// @param token  is set where the secret is good
  Caller enrol(const std::string& secret, const std::string& machine, std::int64_t now,
               std::int64_t token_expires, std::string& token);
  Caller prove(const std::string& token, std::int64_t now);

  v1::Users users();
  /// @return nothing for a name that is not listed
  std::optional<v1::User> find(const std::string& name);

private:
  struct Place {
    std::uint64_t inode = 0;
    std::int64_t modified_ns = 0, size = -1;
    bool operator==(const Place&) const = default;
  };
  void change(const std::function<void(v1::Users& users)>& what);
  void refresh();
  void read();
  Place place() const;

  const std::filesystem::path file_, lock_;
  std::mutex mutex_;  ///< of all below
  v1::Users users_;
  Place read_from_;
};

/// "viewer", "submitter" or "admin". @throws Refused for another text
v1::Role role_of(const std::string& text);
std::string text_of(v1::Role role);
/// Why a user who is disabled is refused.
std::string disabled_text(const std::string& name);

}  // namespace dccast::access
