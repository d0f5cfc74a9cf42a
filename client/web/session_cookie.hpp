#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dccast::client {

/// A browser that has signed in.
struct Session {
  std::string token;            ///< of its user, made for this session
  std::int64_t begun_unix = 0;  ///< [s since 1970]
  std::int64_t seen_unix = 0;   ///< last request that renewed the cookie [s since 1970]
};

/// Sessions live in the browsers alone: the cookie holds the token, sealed with AES-256-GCM. Name
/// and version of the cookie are sealed with it.
class SessionCookie {
public:
  static constexpr std::int64_t idle_s = 12 * 3600, longest_s = 30 * 86400;
  /// A cookie is renewed once this much of its idle time has passed.
  static constexpr std::int64_t renewed_after_s = 600;

  /// @param keys  of 32 bytes; the first one seals, all of them open
  /// @param name  of the cookie
  explicit SessionCookie(std::vector<std::string> keys, std::string name = "__Host-dccast");

  /// Value for Set-Cookie.
  std::string set(const Session& session) const;
  /// Value for Set-Cookie that removes the cookie.
  std::string removal() const;
  /// The session of a request. @param cookies  value of the header Cookie
  /// @return empty: there is none, it is forged, or its time is over
  std::optional<Session> read(const std::string& cookies, std::int64_t now) const;

private:
  std::string sealed(const std::string& text) const;
  std::optional<std::string> opened(const std::string& key, const std::string& sealed) const;

  const std::vector<std::string> keys_;
  const std::string name_;
};

/// The value of a cookie; empty if there is none. @param cookies  value of the header Cookie
std::string cookie_in(const std::string& cookies, const std::string& name);

/// The keys in a file, which is made if it is not there: two lines of 64 hexadecimal digits.
/// @param exchange  a new first key; the former first one still opens what it has sealed
/// Throws CommandFailed: the file cannot be read or written, or holds something else.
std::vector<std::string> cookie_keys(const std::filesystem::path& file, bool exchange);

}  // namespace dccast::client
