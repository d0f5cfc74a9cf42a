#include "server/access/users.hpp"

#include <fcntl.h>
#include <openssl/crypto.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <map>

#include "core/storage/file.hpp"
#include "core/storage/storage_error.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/values/digests.hpp"
#include "proto/values/printable.hpp"

namespace dccast::access {

namespace {

constexpr std::size_t longest_name = 64;
constexpr std::size_t longest_machine = 200;  // and "...", below that of access.proto
constexpr int most_credentials = 100;         // of access.proto
constexpr std::size_t id_bytes = 8, salt_bytes = 16, secret_bytes = 32;
const std::string header = "# Written by dccastd; see docs/remote.md.\n";
constexpr const char* token_begins = "dccast-token-";
constexpr const char* enrolment_begins = "dccast-enrol-";

const std::map<std::string, v1::Role> roles{
    {"viewer", v1::VIEWER}, {"submitter", v1::SUBMITTER}, {"admin", v1::ADMIN}};

void check_name(const std::string& name) {
  const bool right =
      !name.empty() && name.size() <= longest_name && name.front() != '-' &&
      std::all_of(name.begin(), name.end(), [](unsigned char c) {
        return c < 128 && (std::isalnum(c) || c == '.' || c == '_' || c == '-' || c == '@');
      });
  if (!right)
    throw Refused("\"" + values::escaped(values::shortened(name)) +
                  "\" is no name of a user; permitted: 1 to 64 letters, digits and . _ - @");
}

v1::User& user_of(v1::Users& users, const std::string& name) {
  for (v1::User& user : *users.mutable_user())
    if (user.name() == name) return user;
  throw Refused("there is no user \"" + values::escaped(values::shortened(name)) +
                "\"; dccastd user list shows those there are");
}

bool has_expired(const v1::Credential& credential, std::int64_t now) {
  return credential.expires_unix() <= now;
}

void forget_expired(v1::User& user, std::int64_t now) {
  auto& all = *user.mutable_credential();
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](const v1::Credential& one) { return has_expired(one, now); }),
            all.end());
}

/// Adds a credential. @return the secret, which is kept nowhere
std::string add_credential(v1::User& user, bool enrolment, std::int64_t now, std::int64_t expires) {
  forget_expired(user, now);
  if (user.credential_size() >= most_credentials)
    throw Refused("user " + user.name() + " has " + std::to_string(most_credentials) +
                  " tokens; dccastd user rotate revokes them");
  const std::string secret = values::random_hexadecimal(secret_bytes);
  v1::Credential& added = *user.add_credential();
  added.set_id(values::random_hexadecimal(id_bytes));
  added.set_salt(values::random_hexadecimal(salt_bytes));
  added.set_sha256(values::sha256(added.salt() + secret));
  added.set_enrolment(enrolment);
  added.set_created_unix(now);
  added.set_expires_unix(expires);
  return (enrolment ? enrolment_begins : token_begins) + added.id() + "-" + secret;
}

struct Parts {
  std::string id, secret;
};

std::optional<Parts> parts_of(const std::string& text, const std::string& begin) {
  constexpr std::size_t id_digits = 2 * id_bytes, secret_digits = 2 * secret_bytes;
  if (!text.starts_with(begin) || text.size() != begin.size() + id_digits + 1 + secret_digits)
    return std::nullopt;
  return Parts{text.substr(begin.size(), id_digits), text.substr(begin.size() + id_digits + 1)};
}

bool is_secret_of(const v1::Credential& credential, const std::string& secret) {
  const std::string digest = values::sha256(credential.salt() + secret);
  return digest.size() == credential.sha256().size() &&
         ::CRYPTO_memcmp(digest.data(), credential.sha256().data(), digest.size()) == 0;
}

struct Found {
  v1::User* user = nullptr;
  v1::Credential* credential = nullptr;
};

Found find_credential(v1::Users& users, const Parts& parts, bool enrolment) {
  for (v1::User& user : *users.mutable_user())
    for (v1::Credential& one : *user.mutable_credential())
      if (one.enrolment() == enrolment && one.id() == parts.id && is_secret_of(one, parts.secret))
        return {&user, &one};
  return {};
}

Proven proven(const v1::User& user, const v1::Credential& credential) {
  return {user.name(), user.role(), credential.id(), credential.expires_unix()};
}

Proof judge(const Found& found, std::int64_t now, const std::string& what,
            const std::string& remedy) {
  if (found.user == nullptr)
    return {{}, "this " + what + " is unknown here: it was revoked, or used before; " + remedy};
  if (found.user->disabled())
    return {{},
            "user " + found.user->name() +
                " is disabled; an admin can undo it: dccastd user "
                "enable " +
                found.user->name()};
  if (has_expired(*found.credential, now))
    return {{}, "this " + what + " of " + found.user->name() + " has expired; " + remedy};
  return {proven(*found.user, *found.credential), ""};
}

constexpr const char* ask_for_line = "ask an admin for a new line (dccastd user rotate NAME)";

}  // namespace

v1::Role role_of(const std::string& text) {
  const auto found = roles.find(text);
  if (found != roles.end()) return found->second;
  throw Refused("\"" + values::escaped(values::shortened(text)) +
                "\" is no role; permitted: viewer, submitter, admin");
}

std::string text_of(v1::Role role) {
  for (const auto& [text, value] : roles)
    if (value == role) return text;
  return "none";
}

UserStore::UserStore(const std::filesystem::path& directory)
    : file_(directory / "users.toml"), lock_(directory / "users.lock") {}

/// Runs `what` on the newest users, alone, and keeps what it has made of them.
template <typename Change>
auto UserStore::change(Change what) {
  const std::lock_guard guard(mutex_);
  const storage::File lock(lock_, O_RDWR | O_CREAT);
  while (::flock(lock.descriptor(), LOCK_EX) != 0)
    if (errno != EINTR) throw storage::StorageError(errno, lock_.string(), "cannot be locked");
  read();
  auto outcome = what(users_);
  storage::replace_file(file_, header + case_file::to_toml(users_));
  read();
  return outcome;
}

UserStore::Place UserStore::place() const {
  struct stat status;
  if (::stat(file_.c_str(), &status) == 0)
    return {status.st_ino, status.st_mtim.tv_sec * 1'000'000'000 + status.st_mtim.tv_nsec,
            status.st_size};
  if (errno == ENOENT) return {};
  throw storage::StorageError(errno, file_.string(), "cannot be read");
}

void UserStore::read() {
  const Place now = place();
  v1::Users users;
  const std::string text = now == Place{} ? header : storage::read_file(file_);
  if (text != header) {  // a file without any key would count as damaged
    const auto outcome = case_file::read_text(text, file_.string(), users);
    if (!outcome.ok())
      throw Refused(file_.string() + " is damaged (" + outcome.faults.front().field() + ": " +
                    outcome.faults.front().message() +
                    "); restore it from a backup, or remove it and add the users again");
  }
  users_ = std::move(users);
  read_from_ = now;
  ++version_;
}

void UserStore::refresh() {
  if (place() != read_from_) read();
}

std::string UserStore::add(const std::string& name, v1::Role role, std::int64_t now,
                           std::int64_t expires) {
  check_name(name);
  return change([&](v1::Users& users) {
    for (const v1::User& user : users.user())
      if (user.name() == name)
        throw Refused("user " + name + " is there already; dccastd user rotate " + name +
                      " makes a new line, dccastd user role changes the role");
    v1::User& user = *users.add_user();
    user.set_name(name);
    user.set_role(role);
    return add_credential(user, true, now, expires);
  });
}

std::string UserStore::rotate(const std::string& name, std::int64_t now, std::int64_t expires) {
  return change([&](v1::Users& users) {
    v1::User& user = user_of(users, name);
    user.clear_credential();
    return add_credential(user, true, now, expires);
  });
}

void UserStore::remove(const std::string& name) {
  change([&](v1::Users& users) {
    user_of(users, name);
    auto& all = *users.mutable_user();
    all.erase(std::remove_if(all.begin(), all.end(),
                             [&](const v1::User& user) { return user.name() == name; }),
              all.end());
    return true;
  });
}

void UserStore::set_disabled(const std::string& name, bool disabled) {
  change([&](v1::Users& users) {
    user_of(users, name).set_disabled(disabled);
    return true;
  });
}

void UserStore::set_role(const std::string& name, v1::Role role) {
  change([&](v1::Users& users) {
    user_of(users, name).set_role(role);
    return true;
  });
}

bool UserStore::revoke(const std::string& name, const std::string& credential) {
  return change([&](v1::Users& users) {
    auto& all = *user_of(users, name).mutable_credential();
    const auto rest = std::remove_if(
        all.begin(), all.end(), [&](const v1::Credential& one) { return one.id() == credential; });
    const bool was_there = rest != all.end();
    all.erase(rest, all.end());
    return was_there;
  });
}

Proof UserStore::enrol(const std::string& secret, const std::string& machine, std::int64_t now,
                       std::int64_t token_expires, std::string& token) {
  const std::string unknown =
      std::string("this one-time secret is not one of dccastd user add; ") + ask_for_line;
  const auto parts = parts_of(secret, enrolment_begins);
  if (!parts) return {{}, unknown};
  {  // A wrong secret is no reason to write.
    const std::lock_guard guard(mutex_);
    refresh();
    const Found found = find_credential(users_, *parts, true);
    if (Proof proof = judge(found, now, "one-time secret", ask_for_line); !proof.proven)
      return proof;
  }
  return change([&](v1::Users& users) -> Proof {
    const Found found = find_credential(users, *parts, true);
    if (Proof proof = judge(found, now, "one-time secret", ask_for_line); !proof.proven)
      return proof;
    v1::User& user = *found.user;
    auto& all = *user.mutable_credential();
    all.erase(std::remove_if(all.begin(), all.end(),
                             [&](const v1::Credential& one) { return one.id() == parts->id; }),
              all.end());
    token = add_credential(user, false, now, token_expires);
    v1::Credential& added = *user.mutable_credential()->rbegin();
    added.set_machine(values::shortened(values::escaped(machine), longest_machine));
    return {proven(user, added), ""};
  });
}

Proof UserStore::prove(const std::string& token, std::int64_t now) {
  const std::string remedy = std::string("log in again: dccast login; ") + ask_for_line;
  const auto parts = parts_of(token, token_begins);
  if (!parts) return {{}, "what was sent is no token of dccastd; " + remedy};
  const std::lock_guard guard(mutex_);
  refresh();
  return judge(find_credential(users_, *parts, false), now, "token", remedy);
}

v1::Users UserStore::users() {
  const std::lock_guard guard(mutex_);
  refresh();
  return users_;
}

std::optional<v1::User> UserStore::find(const std::string& name) {
  const std::lock_guard guard(mutex_);
  refresh();
  for (const v1::User& user : users_.user())
    if (user.name() == name) return user;
  return std::nullopt;
}

std::int64_t UserStore::version() {
  const std::lock_guard guard(mutex_);
  refresh();
  return version_;
}

}  // namespace dccast::access
