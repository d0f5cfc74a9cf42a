#include "client/web/session_cookie.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <openssl/rand.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <utility>

#include "client/session/failure.hpp"
#include "client/session/private_file.hpp"
#include "proto/values/digests.hpp"
#include "proto/values/owned.hpp"

namespace dccast::client {
namespace {

using Cipher = values::Owned<EVP_CIPHER_CTX, EVP_CIPHER_CTX_free>;
constexpr std::size_t key_bytes = 32, nonce_bytes = 12, tag_bytes = 16;
constexpr const char* version = " 1";

unsigned char* bytes_of(std::string& text) {
  return reinterpret_cast<unsigned char*>(text.data());
}
const unsigned char* bytes_of(const std::string& text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}
int size_of(const std::string& text) {
  return static_cast<int>(text.size());
}

std::string hexadecimal(const std::string& bytes) {
  return values::hexadecimal({bytes_of(bytes), bytes.size()});
}

/// @return empty: other characters than digits of two for each byte
std::string bytes_in(const std::string& digits) {
  std::string bytes(digits.size() / 2, '\0');
  if (digits.size() % 2 != 0) return {};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    unsigned value = 0;
    const char* const end = digits.data() + 2 * i + 2;
    const auto read = std::from_chars(end - 2, end, value, 16);
    if (read.ec != std::errc() || read.ptr != end) return {};
    bytes[i] = static_cast<char>(value);
  }
  return bytes;
}

std::optional<Session> session_in(const std::string& text) {
  Session session;
  std::istringstream words(text);
  if (!(words >> session.begun_unix >> session.seen_unix >> session.token)) return std::nullopt;
  return session;
}

constexpr const char* attributes = "; Path=/; Secure; HttpOnly; SameSite=Strict";

}  // namespace

std::string cookie_in(const std::string& cookies, const std::string& name) {
  const std::string all = "; " + cookies, begin = "; " + name + "=";
  const auto at = all.find(begin);
  if (at == std::string::npos) return {};
  const auto from = at + begin.size();
  return all.substr(from, all.find(';', from) - from);
}

SessionCookie::SessionCookie(std::vector<std::string> keys, std::string name)
    : keys_(std::move(keys)), name_(std::move(name)) {}

std::string SessionCookie::set(const Session& session) const {
  const std::string text =
      fmt::format("{} {} {}", session.begun_unix, session.seen_unix, session.token);
  return fmt::format("{}={}; Max-Age={}{}", name_, hexadecimal(sealed(text)), idle_s, attributes);
}

std::string SessionCookie::removal() const {
  return fmt::format("{}=; Max-Age=0{}", name_, attributes);
}

std::optional<Session> SessionCookie::read(const std::string& cookies, std::int64_t now) const {
  const std::string bytes = bytes_in(cookie_in(cookies, name_));
  for (const std::string& key : keys_) {
    const auto text = opened(key, bytes);
    const auto session = text ? session_in(*text) : std::nullopt;
    if (!session) continue;
    const bool is_good = now < session->seen_unix + idle_s && now < session->begun_unix + longest_s;
    return is_good ? session : std::nullopt;
  }
  return std::nullopt;
}

std::string SessionCookie::sealed(const std::string& text) const {
  const std::string beside = name_ + version;
  std::string nonce(nonce_bytes, '\0'), closed(text.size(), '\0'), tag(tag_bytes, '\0');
  const Cipher cipher(EVP_CIPHER_CTX_new());
  int size = 0;
  const bool is_done =
      ::RAND_bytes(bytes_of(nonce), nonce_bytes) == 1 &&
      ::EVP_EncryptInit_ex(cipher.get(), ::EVP_aes_256_gcm(), nullptr, bytes_of(keys_.front()),
                           bytes_of(nonce)) == 1 &&
      ::EVP_EncryptUpdate(cipher.get(), nullptr, &size, bytes_of(beside), size_of(beside)) == 1 &&
      ::EVP_EncryptUpdate(cipher.get(), bytes_of(closed), &size, bytes_of(text), size_of(text)) ==
          1 &&
      ::EVP_EncryptFinal_ex(cipher.get(), nullptr, &size) == 1 &&
      ::EVP_CIPHER_CTX_ctrl(cipher.get(), EVP_CTRL_GCM_GET_TAG, tag_bytes, tag.data()) == 1;
  if (!is_done) throw std::runtime_error("OpenSSL cannot seal a cookie");
  return nonce + closed + tag;
}

std::optional<std::string> SessionCookie::opened(const std::string& key,
                                                 const std::string& sealed) const {
  if (sealed.size() < nonce_bytes + tag_bytes) return std::nullopt;
  const std::string beside = name_ + version;
  const std::string closed = sealed.substr(nonce_bytes, sealed.size() - nonce_bytes - tag_bytes);
  std::string tag = sealed.substr(sealed.size() - tag_bytes), text(closed.size(), '\0');
  const Cipher cipher(EVP_CIPHER_CTX_new());
  int size = 0;
  const bool is_done =
      ::EVP_DecryptInit_ex(cipher.get(), ::EVP_aes_256_gcm(), nullptr, bytes_of(key),
                           bytes_of(sealed)) == 1 &&
      ::EVP_DecryptUpdate(cipher.get(), nullptr, &size, bytes_of(beside), size_of(beside)) == 1 &&
      ::EVP_DecryptUpdate(cipher.get(), bytes_of(text), &size, bytes_of(closed), size_of(closed)) ==
          1 &&
      ::EVP_CIPHER_CTX_ctrl(cipher.get(), EVP_CTRL_GCM_SET_TAG, tag_bytes, tag.data()) == 1 &&
      ::EVP_DecryptFinal_ex(cipher.get(), nullptr, &size) == 1;
  if (!is_done) return std::nullopt;
  return text;
}

std::vector<std::string> cookie_keys(const std::filesystem::path& file, bool exchange) {
  std::vector<std::string> keys;
  std::string line;
  for (std::ifstream lines(file); std::getline(lines, line);) keys.push_back(bytes_in(line));
  for (const std::string& key : keys)
    if (key.size() != key_bytes)
      throw invalid(file.string() +
                    ": does not hold keys of cookies; delete it, and all users sign in again");
  if (!keys.empty() && !exchange) return keys;
  if (keys.empty() && std::filesystem::exists(file))
    throw invalid(file.string() + ": is empty or cannot be read; dccast-web runs as its owner");

  keys.insert(keys.begin(), bytes_in(values::random_hexadecimal(key_bytes)));
  keys.resize(std::min<std::size_t>(keys.size(), 2));
  std::string text;
  for (const std::string& key : keys) text += hexadecimal(key) + "\n";
  const std::string fault = write_private_file(file, text);
  if (!fault.empty())
    throw CommandFailed(ExitCode::output_lost,
                        fmt::format("{}: cannot be written: {}", file.string(), fault));
  return keys;
}

}  // namespace dccast::client
