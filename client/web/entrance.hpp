#pragma once

#include <openssl/ossl_typ.h>

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "client/web/request.hpp"

namespace dccast::client {

/// Decides which requests a web server answers.
class Entrance {
public:
  virtual ~Entrance() = default;
  /// Whether a value of the header Host names this server.
  virtual bool is_own_name(const std::string& host) const = 0;
  /// Judges a request, and notes in it whose it is.
  /// @return the reply to one that is not let in
  virtual std::optional<Reply> judge(Request& request) = 0;
};

/// Lets in the browser of one user of this machine: a key that works once is exchanged for the
/// session's cookie. Whatever changes something must come from a page of this origin.
class KeyEntrance : public Entrance {
public:
  /// @param port  of the server, on the loopback address
  explicit KeyEntrance(int port);

  bool is_own_name(const std::string& host) const override;
  std::optional<Reply> judge(Request& request) override;

  /// An address that opens the dashboard once.
  std::string address() const { return "http://127.0.0.1" + port_ + "/?key=" + key_; }
  /// Called once that address has let a browser in.
  void when_entered(std::function<void()> call) { when_entered_ = std::move(call); }

private:
  /// Whether the key is good; it is not afterwards.
  bool take_key(const std::string& key);
  /// Name of the session's cookie, which contains the port.
  std::string cookie_name() const;

  const std::string port_;  // ":7300"
  /// Value of the session's cookie, and the key: random, never stored.
  const std::string session_, key_;
  std::atomic<bool> is_used_ = false;
  std::function<void()> when_entered_ = [] {};
};

/// Whether a name with or without port, as in the header Host, stands in a certificate.
bool is_name_of(const X509* certificate, const std::string& host);

}  // namespace dccast::client
