#include "client/web/entrance.hpp"

#include <openssl/crypto.h>
#include <openssl/x509v3.h>

#include "client/web/session_cookie.hpp"
#include "proto/values/address.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

/// A browser sends a strict cookie only from a page of this origin, not with the redirection that
/// sets it if another page, such as a file, led there. This page therefore forwards to the first
/// page; its script keeps the fragment, which names the page to show.
constexpr const char* threshold_path = "/entered";
constexpr const char* threshold_page =
    "<!DOCTYPE html>\n<meta charset=\"utf-8\">\n<title>dccast</title>\n"
    "<script src=\"/entered.js\"></script>\n"
    "<noscript><meta http-equiv=\"refresh\" content=\"0; url=/\"></noscript>\n";

/// 256 random bits.
std::string secret() {
  return values::random_hexadecimal(32);
}

/// Constant-time comparison.
bool equal(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

Reply forbidden(const std::string& why) {
  return {.body = why + "\n", .status = 403};
}

}  // namespace

bool is_name_of(const X509* certificate, const std::string& host) {
  const std::string name = values::host_and_port(host).host;
  auto* readable = const_cast<X509*>(certificate);
  return X509_check_host(readable, name.data(), name.size(), 0, nullptr) == 1 ||
         X509_check_ip_asc(readable, name.c_str(), 0) == 1;
}

KeyEntrance::KeyEntrance(int port)
    : port_(":" + std::to_string(port)), session_(secret()), key_(secret()) {}

/// Cookies do not distinguish ports.
std::string KeyEntrance::cookie_name() const {
  return "dccast_" + port_.substr(1);
}

bool KeyEntrance::is_own_name(const std::string& host) const {
  return host == "127.0.0.1" + port_ || host == "localhost" + port_ || host == "[::1]" + port_;
}

bool KeyEntrance::take_key(const std::string& key) {
  return equal(key, key_) && !is_used_.exchange(true);
}

std::optional<Reply> KeyEntrance::judge(Request& request) {
  if (request.path == threshold_path)
    return Reply{.body = threshold_page, .type = "text/html; charset=utf-8"};

  const std::string origin = request.header("origin");
  if (origin.empty() ? request.method != "GET" : origin != "http://" + request.header("host"))
    return forbidden("Only pages of this dashboard may ask this.");
  if (equal(cookie_in(request.header("cookie"), cookie_name()), session_)) return std::nullopt;

  if (request.path == "/" && take_key(request.value("key"))) {
    when_entered_();
    const std::string cookie =
        cookie_name() + "=" + session_ + "; HttpOnly; SameSite=Strict; Path=/";
    return Reply{.status = 302, .headers = {{"Set-Cookie", cookie}, {"Location", threshold_path}}};
  }
  return forbidden(
      "The key in the address is missing or was used before. Start `dccast dashboard` again.");
}

}  // namespace dccast::client
