#include "client/web/session_entrance.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <ctime>
#include <utility>

#include "client/web/connect_messages.hpp"

namespace dccast::client {
namespace {

constexpr const char* token_begin = "dccast-token-";
constexpr const char* line_begin = "dccast-enrol-";
constexpr const char* enrol_path = "/dccast.v1.SimulationService/Enrol";

Reply refusal(grpc::StatusCode code, const std::string& message) {
  return error_reply({code, message}, "");
}

/// Tables are read by spreadsheets, which know no other scheme than Basic.
bool is_table(const Request& request) {
  return request.method == "GET" && request.path.ends_with(".csv");
}

/// User and password of `Authorization: Basic`; empty: there are none.
std::pair<std::string, std::string> basic(const std::string& authorization) {
  constexpr std::string_view scheme = "Basic ";
  constexpr std::size_t longest = 1000;
  if (!authorization.starts_with(scheme) || authorization.size() > longest) return {};
  std::string text = authorization.substr(scheme.size()), decoded(text.size(), '\0');
  const int size = ::EVP_DecodeBlock(reinterpret_cast<unsigned char*>(decoded.data()),
                                     reinterpret_cast<const unsigned char*>(text.data()),
                                     static_cast<int>(text.size()));
  if (size < 0) return {};
  decoded.resize(static_cast<std::size_t>(size));
  decoded.resize(decoded.find_last_not_of('\0') + 1);  // of the padding
  const auto colon = decoded.find(':');
  if (colon == std::string::npos) return {};
  return {decoded.substr(0, colon), decoded.substr(colon + 1)};
}

/// Addresses end up in logs and histories.
bool has_secret_in_address(const Request& request) {
  static constexpr std::array names{"token", "access_token", "authorization", "secret", "line"};
  const auto has_secret = [](const std::string& text) {
    return text.find(token_begin) != std::string::npos ||
           text.find(line_begin) != std::string::npos;
  };
  if (has_secret(request.path)) return true;
  for (const auto& [name, value] : request.query) {
    if (has_secret(name) || has_secret(value)) return true;
    for (const char* secret : names)
      if (name == secret) return true;
  }
  return false;
}

/// Whether a text may be a token; the daemon knows whether it is.
bool is_token(const std::string& text) {
  constexpr std::size_t longest = 200;
  constexpr const char* permitted = "0123456789abcdefghijklmnopqrstuvwxyz-";
  return text.starts_with(token_begin) && text.size() <= longest &&
         text.find_first_not_of(permitted) == std::string::npos;
}

/// The browser's address as the proxy states it, which adds it after what the browser has sent.
std::string forwarded_address(const std::string& header) {
  constexpr std::size_t longest = 45;
  std::string last = header.substr(header.find_last_of(", ") + 1);
  const bool is_address = !last.empty() && last.size() <= longest &&
                          last.find_first_not_of("0123456789abcdefABCDEF.:") == std::string::npos;
  return is_address ? last : "";
}

}  // namespace

std::string SignInAttempts::take(const std::string& address, std::int64_t now) {
  const std::lock_guard lock(mutex_);
  if (const std::int64_t minute = now / 60; minute != minute_) {
    minute_ = minute;
    taken_ = 0;
    taken_by_.clear();
  }

  if (taken_ >= most) return fmt::format("{} attempts to sign in within a minute", most);
  int& own = taken_by_[address];
  if (own >= most_of_address)
    return fmt::format("{} attempts to sign in from {} within a minute", own, address);
  ++own;
  ++taken_;
  return {};
}

bool SessionEntrance::is_own_name(const std::string& host) const {
  return server_ == nullptr || is_name_of(server_->certificate().get(), host);
}

bool SessionEntrance::is_of_own_page(const Request& request) const {
  const std::string own = origin_.empty() ? "https://" + request.header("host") : origin_;
  const std::string origin = request.header("origin"), type = request.header("content-type");
  if (request.method == "GET") return origin.empty() || origin == own;
  // A page of another site cannot send PUT without a permission that this server never gives.
  return origin == own && (request.method == "PUT" || type.starts_with("application/json") ||
                           type.starts_with("application/connect+"));
}

void SessionEntrance::identify(Request& request, std::int64_t now) const {
  constexpr std::string_view scheme = "Bearer ";
  if (const std::string stated = request.header("authorization"); stated.starts_with(scheme)) {
    const std::string token = stated.substr(scheme.size());
    if (is_token(token)) request.token = token;
    return;
  }
  if (is_table(request)) {
    const auto [user, token] = basic(request.header("authorization"));
    if (is_token(token)) {
      request.user = user;
      request.token = token;
      return;
    }
  }
  if (!is_of_own_page(request)) return;
  auto session = cookie_.read(request.header("cookie"), now);
  if (!session) return;

  request.token = session->token;
  if (now < session->seen_unix + SessionCookie::renewed_after_s) return;
  session->seen_unix = now;
  request.set_cookie = cookie_.set(*session);
}

bool SessionEntrance::take_place(Request& request) {
  const std::lock_guard lock(places_->mutex);
  int& taken = places_->taken[request.token];
  if (taken >= most_under_way) return false;

  ++taken;
  request.place = std::shared_ptr<void>(nullptr, [places = places_, token = request.token](void*) {
    const std::lock_guard freeing(places->mutex);
    const auto found = places->taken.find(token);
    if (--found->second == 0) places->taken.erase(found);
  });
  return true;
}

std::optional<Reply> SessionEntrance::judge(Request& request) {
  if (has_secret_in_address(request))
    return refusal(grpc::INVALID_ARGUMENT,
                   "a token or line in an address ends up in logs; send it as Authorization: "
                   "Bearer TOKEN, and make another one: this one may be known");
  if (request.is_of_file) return std::nullopt;
  if (server_ == nullptr)
    if (const auto stated = forwarded_address(request.header("x-forwarded-for")); !stated.empty())
      request.address = stated;

  const std::int64_t now = std::time(nullptr);
  const bool signs_in = request.path == sign_in_path;
  if (signs_in && !is_of_own_page(request))
    return refusal(grpc::PERMISSION_DENIED, "only the page of this server signs in");
  if (signs_in || request.path == enrol_path) {
    const std::string why = attempts_.take(request.address, now);
    if (why.empty()) return std::nullopt;
    return refusal(grpc::RESOURCE_EXHAUSTED, why + "; wait a minute, then try again");
  }

  identify(request, now);
  if (request.token.empty()) {
    auto reply = refusal(
        grpc::UNAUTHENTICATED,
        "you are not signed in here, or were not for 12 hours; open a link of `dccastd user "
        "line`. Programs send Authorization: Bearer TOKEN");
    if (is_table(request)) reply.headers.emplace_back("WWW-Authenticate", "Basic realm=\"dccast\"");
    return reply;
  }
  if (take_place(request)) return std::nullopt;
  return refusal(grpc::RESOURCE_EXHAUSTED,
                 fmt::format("{} requests of one session are under way here, which is the limit; "
                             "wait for one of them to end",
                             most_under_way));
}

}  // namespace dccast::client
