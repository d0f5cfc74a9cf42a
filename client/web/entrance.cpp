#include "client/web/entrance.hpp"

#include <openssl/crypto.h>
#include <openssl/x509v3.h>

#include <algorithm>

#include "proto/values/address.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

constexpr std::size_t most_keys = 16;  // that are waiting to be used

/// 256 random bits.
std::string secret() {
  return values::random_hexadecimal(32);
}

/// Constant-time comparison.
bool equal(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

/// The value of a cookie; empty if there is none.
std::string cookie_of(const std::string& cookies, const std::string& name) {
  const std::string all = "; " + cookies, begin = "; " + name + "=";
  const auto at = all.find(begin);
  if (at == std::string::npos) return {};
  const auto from = at + begin.size();
  return all.substr(from, all.find(';', from) - from);
}

}  // namespace

Entrance::Entrance(std::string host, int port, const X509* certificate)
    : host_(std::move(host)),
      port_(":" + std::to_string(port)),
      certificate_(certificate),
      session_(secret()) {}

std::string Entrance::origin() const {
  return (certificate_ == nullptr ? "http://" : "https://") + host_ + port_;
}

/// Cookies do not distinguish ports.
std::string Entrance::cookie_name() const {
  return "dccast_" + port_.substr(1);
}

std::string Entrance::address() {
  const std::lock_guard lock(mutex_);
  if (keys_.size() >= most_keys) keys_.erase(keys_.begin());
  return origin() + "/?key=" + *keys_.insert(secret()).first;
}

bool Entrance::is_own_name(const std::string& host) const {
  if (certificate_ == nullptr)
    return host == host_ + port_ || host == "localhost" + port_ || host == "[::1]" + port_;
  const std::string name = values::host_and_port(host).host;
  auto* certificate = const_cast<X509*>(certificate_);
  return X509_check_host(certificate, name.data(), name.size(), 0, nullptr) == 1 ||
         X509_check_ip_asc(certificate, name.c_str(), 0) == 1;
}

bool Entrance::take_key(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::ranges::find_if(keys_, [&](const std::string& known) { return equal(known, key); });
  if (found == keys_.end()) return false;
  keys_.erase(found);
  return true;
}

Entrance::Decision Entrance::decide(const Visit& visit) {
  const std::string own_pages = (certificate_ == nullptr ? "http://" : "https://") + visit.host;
  if (visit.origin.empty() ? visit.changes : visit.origin != own_pages)
    return {.refusal = "Only pages of this dashboard may ask this."};
  if (equal(cookie_of(visit.cookies, cookie_name()), session_)) return {.admitted = true};
  if (visit.is_first_page && take_key(visit.key))
    return {.cookie = cookie_name() + "=" + session_ + "; HttpOnly; SameSite=Strict; Path=/" +
                      (certificate_ == nullptr ? "" : "; Secure")};
  return {.refusal =
              "The key in the address is missing or was used before. Start `dccast dashboard` "
              "again, or press \"Another screen\" in the one that is open."};
}

}  // namespace dccast::client
