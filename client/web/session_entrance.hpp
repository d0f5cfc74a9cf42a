#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "client/web/entrance.hpp"
#include "client/web/session_cookie.hpp"
#include "proto/http/server.hpp"

namespace dccast::client {

/// Bounds attempts to sign in within a minute, of each address and of all together.
class SignInAttempts {
public:
  static constexpr int most_of_address = 10, most = 100;

  /// @param now  [s since 1970]. @return why one more is refused; empty: it is not
  std::string take(const std::string& address, std::int64_t now);

private:
  std::mutex mutex_;
  std::int64_t minute_ = 0;
  int taken_ = 0;
  std::map<std::string, int> taken_by_;
};

/// Lets in the users of the daemon, each with a token: of `Authorization: Bearer`, else of the
/// session's cookie. The cookie counts for pages of this server alone. Files are for everybody, and
/// so is signing in.
class SessionEntrance : public Entrance {
public:
  /// Requests of a user that are answered at once; further ones are refused.
  static constexpr int most_under_way = 32;
  static constexpr const char* sign_in_path = "/session/in";

  /// @param origin  "https://dccast.plant.example": of the own pages; empty: that of the Host of
  ///                each request, which stands in the certificate
  /// @param server  null: it is behind a proxy, which states the address of the browser
  ///                (X-Forwarded-For); else its certificate has its names
  SessionEntrance(SessionCookie cookie, std::string origin, const http::Server* server)
      : cookie_(std::move(cookie)), origin_(std::move(origin)), server_(server) {}

  bool is_own_name(const std::string& host) const override;
  std::optional<Reply> judge(Request& request) override;
  const SessionCookie& cookie() const { return cookie_; }

private:
  /// Notes the token of a request, if it has one that counts.
  void identify(Request& request, std::int64_t now) const;
  /// Whether a request comes from a page of this server.
  bool is_of_own_page(const Request& request) const;
  /// Takes a place among the requests of the user. @return whether there was one
  bool take_place(Request& request);

  const SessionCookie cookie_;
  const std::string origin_;
  const http::Server* const server_;
  SignInAttempts attempts_;

  /// Requests under way by token, shared with the places that are taken.
  struct Places {
    std::mutex mutex;
    std::map<std::string, int> taken;
  };
  const std::shared_ptr<Places> places_ = std::make_shared<Places>();
};

}  // namespace dccast::client
