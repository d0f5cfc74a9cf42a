#pragma once

#include <openssl/ossl_typ.h>

#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>

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
  virtual std::optional<http::Reply> judge(Request& request) = 0;
};

/// Lets in the browsers of one user: a key that works once is exchanged for the session's cookie.
/// Whatever changes something must come from a page of this origin.
class KeyEntrance : public Entrance {
public:
  /// @param host         as addresses name this server
  /// @param certificate  of this server, whose names are its own; null: HTTP on the loopback
  ///                     address, with loopback's names
  KeyEntrance(std::string host, int port, const X509* certificate);

  /// Whether its certificate, if any, is for its host.
  bool knows_itself() const { return is_own_name(host_ + port_); }
  bool is_own_name(const std::string& host) const override;
  std::optional<http::Reply> judge(Request& request) override;

  /// An address that opens the dashboard once.
  std::string address();
  /// Called each time such an address has let a browser in.
  void when_entered(std::function<void()> call) { when_entered_ = std::move(call); }

private:
  /// Whether the key is good; it is not afterwards.
  bool take_key(const std::string& key);
  /// Origin of pages at a host, as browsers send it.
  std::string origin_of(const std::string& host) const;
  /// Name of the session's cookie, which contains the port.
  std::string cookie_name() const;

  const std::string host_;
  const std::string port_;  // ":7300"
  const X509* const certificate_;
  /// Value of the session's cookie: random, never stored.
  const std::string session_;
  std::function<void()> when_entered_ = [] {};
  std::mutex mutex_;
  /// Keys that have not been used.
  std::set<std::string> keys_;
};

/// Whether a name with or without port, as in the header Host, stands in a certificate.
bool is_name_of(const X509* certificate, const std::string& host);

}  // namespace dccast::client
