#include "server/access/users.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <openssl/crypto.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <map>

#include "core/storage/file.hpp"
#include "core/storage/file_lock.hpp"
#include "core/storage/storage_error.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/values/digests.hpp"
#include "proto/values/printable.hpp"

namespace dccast::access {

namespace {

constexpr std::size_t longest_name = 64;
constexpr std::size_t longest_machine = 200;        // with "..." below the limit of access.proto
constexpr int largest_number_of_credentials = 100;  // limit of access.proto
constexpr std::size_t id_bytes = 8, salt_bytes = 16, secret_bytes = 32;
const std::string header = "# Written by dccastd; see docs/remote.md.\n";
constexpr const char* token_prefix = "dccast-token-";
constexpr const char* enrolment_prefix = "dccast-enrol-";

const std::map<std::string, v1::Role> roles{
    {"viewer", v1::VIEWER}, {"submitter", v1::SUBMITTER}, {"admin", v1::ADMIN}};

void check_name(const std::string& name) {
  const bool is_valid =
      !name.empty() && name.size() <= longest_name && name.front() != '-' &&
      std::all_of(name.begin(), name.end(), [](unsigned char c) {
        return c < 128 && (std::isalnum(c) || c == '.' || c == '_' || c == '-' || c == '@');
      });
  if (!is_valid)
    throw Refused(
        fmt::format("\"{}\" is no name of a user; permitted: 1 to 64 letters, digits and . _ - @",
                    values::shown(name)));
}

v1::User& require_user(v1::Users& users, const std::string& name) {
  for (v1::User& user : *users.mutable_user())
    if (user.name() == name) return user;
  throw Refused(fmt::format("there is no user \"{}\"; dccastd user list shows those there are",
                            values::shown(name)));
}

bool has_expired(const v1::Credential& credential, std::int64_t now) {
  return credential.expires_unix() <= now;
}

/// @return whether there was one
template <class Entry, class Condition>
bool erase_if(google::protobuf::RepeatedPtrField<Entry>& all, Condition condition) {
  const auto rest = std::remove_if(all.begin(), all.end(), condition);
  const bool found = rest != all.end();
  all.erase(rest, all.end());
  return found;
}

bool erase_credential(v1::User& user, const std::string& id) {
  return erase_if(*user.mutable_credential(),
                  [&](const v1::Credential& credential) { return credential.id() == id; });
}

/// Sessions of browsers, which dccast-web names so, are many and easily made again.
void erase_oldest_session(v1::User& user) {
  constexpr const char* of_web = "web";
  for (const v1::Credential& credential : user.credential())  // oldest first
    if (credential.machine() == of_web) {
      erase_credential(user, std::string(credential.id()));
      return;
    }
}

enum class Kind { token, enrolment };

/// Adds a credential. @return the secret, which is not stored
std::string add_credential(v1::User& user, Kind kind, std::int64_t now, std::int64_t expires) {
  erase_if(*user.mutable_credential(),
           [&](const v1::Credential& credential) { return has_expired(credential, now); });
  if (user.credential_size() >= largest_number_of_credentials) erase_oldest_session(user);
  if (user.credential_size() >= largest_number_of_credentials)
    throw refusal::LimitReached(
        {.cause = fmt::format("user {} has {} tokens", user.name(), user.credential_size()),
         .limit = "tokens of a user",
         .permitted = std::to_string(largest_number_of_credentials),
         .remedy = fmt::format("revoke some: dccast tokens --end ID, or dccastd user revoke {} ID",
                               user.name())});

  const std::string secret = values::random_hexadecimal(secret_bytes);
  v1::Credential& added = *user.add_credential();
  added.set_id(values::random_hexadecimal(id_bytes));
  added.set_salt(values::random_hexadecimal(salt_bytes));
  added.set_sha256(values::sha256(added.salt() + secret));
  added.set_enrolment(kind == Kind::enrolment);
  added.set_created_unix(now);
  added.set_expires_unix(expires);

  const char* prefix = kind == Kind::enrolment ? enrolment_prefix : token_prefix;
  return fmt::format("{}{}-{}", prefix, added.id(), secret);
}

/// A token or one-time secret as it is sent.
struct Parts {
  std::string id, secret;
};

std::optional<Parts> parse_secret(const std::string& text, const std::string& begin) {
  constexpr std::size_t id_digits = 2 * id_bytes, secret_digits = 2 * secret_bytes;
  if (!text.starts_with(begin) || text.size() != begin.size() + id_digits + 1 + secret_digits)
    return std::nullopt;
  return Parts{text.substr(begin.size(), id_digits), text.substr(begin.size() + id_digits + 1)};
}

bool matches(const v1::Credential& credential, const std::string& secret) {
  const std::string digest = values::sha256(credential.salt() + secret);
  return digest.size() == credential.sha256().size() &&
         ::CRYPTO_memcmp(digest.data(), credential.sha256().data(), digest.size()) == 0;
}

struct Found {
  v1::User* user = nullptr;
  v1::Credential* credential = nullptr;
};

Found find_credential(v1::Users& users, const Parts& parts, Kind kind) {
  for (v1::User& user : *users.mutable_user())
    for (v1::Credential& credential : *user.mutable_credential())
      if (credential.enrolment() == (kind == Kind::enrolment) && credential.id() == parts.id &&
          matches(credential, parts.secret))
        return {&user, &credential};
  return {};
}

Caller refused(refusal::Facts why) {
  return {.by = ProvenBy::token, .refusal = std::move(why)};
}

Caller proven(const v1::User& user, const v1::Credential& credential) {
  return {.name = user.name(),
          .role = user.role(),
          .by = ProvenBy::token,
          .credential = credential.id(),
          .expires_unix = credential.expires_unix()};
}

/// @param proof  "token" or "one-time secret", for the text of a refusal
Caller judge(const Found& found, std::int64_t now, const std::string& proof,
             const std::string& remedy) {
  if (found.user == nullptr)
    return refused(not_proven(
        fmt::format("this {} is unknown here: it was revoked, or used before", proof), remedy));

  const std::string& name = found.user->name();
  if (found.user->disabled()) return refused(disabled(name));
  if (has_expired(*found.credential, now))
    return refused(not_proven(fmt::format("this {} of {} has expired", proof, name), remedy));
  return proven(*found.user, *found.credential);
}

constexpr const char* ask_for_line = "ask an admin for a new line (dccastd user rotate NAME)";

}  // namespace

std::string text_of(ProvenBy proof) {
  if (proof == ProvenBy::token) return "token";
  return proof == ProvenBy::certificate ? "certificate" : "local user";
}

refusal::Facts not_proven(std::string cause, std::string remedy) {
  return {.reason = v1::ErrorInfo::NOT_LOGGED_IN,
          .cause = std::move(cause),
          .remedy = std::move(remedy)};
}

refusal::Facts disabled(const std::string& name) {
  return not_proven(fmt::format("user {} is disabled", name),
                    fmt::format("an admin can undo it: dccastd user enable {}", name));
}

std::string sign_in_link(const std::string& web, const std::string& secret) {
  return fmt::format("{}/sign-in.html#{}", web, secret);
}

v1::Role parse_role(const std::string& text) {
  const auto found = roles.find(text);
  if (found != roles.end()) return found->second;
  throw Refused(
      fmt::format("\"{}\" is no role; permitted: viewer, submitter, admin", values::shown(text)));
}

std::string text_of(v1::Role role) {
  for (const auto& [text, value] : roles)
    if (value == role) return text;
  return "none";
}

UserStore::UserStore(const std::filesystem::path& directory)
    : file_(directory / "users.toml"), lock_(directory / "users.lock") {}

/// Reads the newest users, applies an edit under the lock, and writes them. Calls that read the
/// users go on while this one waits for another process.
void UserStore::change(const std::function<void(v1::Users& users)>& edit) {
  const storage::FileLock lock(lock_, storage::longest_lock_wait);
  if (!lock)
    throw storage::StorageError(EAGAIN, lock_.string(), "is locked by another process; try again");

  const std::lock_guard guard(mutex_);

  read();
  edit(users_);
  storage::replace_file(file_, header + case_file::to_toml(users_));
  read();
}

UserStore::FileVersion UserStore::version() const {
  struct stat status;
  if (::stat(file_.c_str(), &status) == 0)
    return {status.st_ino, status.st_mtim.tv_sec * 1'000'000'000 + status.st_mtim.tv_nsec,
            status.st_size};
  if (errno == ENOENT) return {};
  throw storage::StorageError(errno, file_.string(), "cannot be read");
}

void UserStore::read() {
  const FileVersion present = version();
  v1::Users users;
  const std::string text = present == FileVersion{} ? header : storage::read_file(file_);
  if (text != header) {  // a file without any key would count as damaged
    const auto outcome = case_file::read_text(text, file_.string(), users);
    if (!outcome.ok())
      throw Refused(fmt::format(
          "{} is damaged ({}: {}); restore it from a backup, or remove it and add the users again",
          file_.string(), outcome.faults.front().field(), outcome.faults.front().message()));
  }
  users_ = std::move(users);
  read_version_ = present;
}

void UserStore::refresh() {
  if (version() != read_version_) read();
}

std::string UserStore::add(const std::string& name, v1::Role role, std::int64_t now,
                           std::int64_t expires) {
  check_name(name);
  std::string secret;
  change([&](v1::Users& users) {
    if (std::ranges::find(users.user(), name, &v1::User::name) != users.user().end())
      throw Refused(
          fmt::format("user {} is there already; dccastd user rotate {} makes a new line, "
                      "dccastd user role changes the role",
                      name, name));

    v1::User& user = *users.add_user();
    user.set_name(name);
    user.set_role(role);
    secret = add_credential(user, Kind::enrolment, now, expires);
  });
  return secret;
}

std::string UserStore::rotate(const std::string& name, std::int64_t now, std::int64_t expires) {
  std::string secret;
  change([&](v1::Users& users) {
    v1::User& user = require_user(users, name);
    user.clear_credential();
    secret = add_credential(user, Kind::enrolment, now, expires);
  });
  return secret;
}

std::string UserStore::add_line(const std::string& name, const std::string& token, std::int64_t now,
                                std::int64_t expires) {
  std::string secret;
  change([&](v1::Users& users) {
    v1::User& user = require_user(users, name);
    secret = add_credential(user, Kind::enrolment, now, expires);
    user.mutable_credential()->rbegin()->set_machine(
        values::shortened(values::escaped(token), longest_machine));
  });
  return secret;
}

void UserStore::remove(const std::string& name) {
  change([&](v1::Users& users) {
    require_user(users, name);
    erase_if(*users.mutable_user(), [&](const v1::User& user) { return user.name() == name; });
  });
}

void UserStore::set_disabled(const std::string& name, bool disabled) {
  change([&](v1::Users& users) { require_user(users, name).set_disabled(disabled); });
}

void UserStore::set_role(const std::string& name, v1::Role role) {
  change([&](v1::Users& users) { require_user(users, name).set_role(role); });
}

bool UserStore::revoke(const std::string& name, const std::string& credential) {
  bool found = false;
  change(
      [&](v1::Users& users) { found = erase_credential(require_user(users, name), credential); });
  return found;
}

Caller UserStore::enrol(const std::string& secret, const std::string& machine, std::int64_t now,
                        std::int64_t token_expires, std::string& token) {
  const bool renews = secret.starts_with(token_prefix);
  const auto parts = parse_secret(secret, renews ? token_prefix : enrolment_prefix);
  if (!parts)
    return refused(not_proven("this one-time secret is not one of dccastd user add", ask_for_line));

  Found found;
  const auto judged = [&](v1::Users& users) {
    found = find_credential(users, *parts, renews ? Kind::token : Kind::enrolment);
    return judge(found, now, renews ? "token" : "one-time secret", ask_for_line);
  };

  // A wrong secret must not cause a write.
  {
    const std::lock_guard guard(mutex_);
    refresh();
    if (Caller caller = judged(users_); !caller.proven()) return caller;
  }

  Caller caller;
  change([&](v1::Users& users) {
    caller = judged(users);
    if (!caller.proven()) return;

    v1::User& user = *found.user;
    const std::string name = found.credential->machine();  // which the line gives
    if (!renews) erase_credential(user, parts->id);
    token = add_credential(user, Kind::token, now, token_expires);

    v1::Credential& added = *user.mutable_credential()->rbegin();
    added.set_machine(name.empty() ? values::shortened(values::escaped(machine), longest_machine)
                                   : name);
    caller = proven(user, added);
  });
  return caller;
}

Caller UserStore::prove(const std::string& token, std::int64_t now) {
  const std::string remedy = fmt::format("log in again: dccast login; {}", ask_for_line);
  const auto parts = parse_secret(token, token_prefix);
  if (!parts) return refused(not_proven("what was sent is no token of dccastd", remedy));

  const std::lock_guard guard(mutex_);
  refresh();
  return judge(find_credential(users_, *parts, Kind::token), now, "token", remedy);
}

v1::Users UserStore::users() {
  const std::lock_guard guard(mutex_);
  refresh();
  return users_;
}

std::optional<v1::User> UserStore::find(const std::string& name) {
  const std::lock_guard guard(mutex_);
  refresh();
  const auto found = std::ranges::find(users_.user(), name, &v1::User::name);
  return found == users_.user().end() ? std::nullopt : std::optional(*found);
}

}  // namespace dccast::access
