#pragma once

#include <openssl/ossl_typ.h>

#include <mutex>
#include <set>
#include <string>

namespace dccast::client {

/// Authenticates browsers: a key that works once is exchanged for the session's cookie. Whatever
/// changes something must come from a page of this origin.
class Entrance {
public:
  /// @param host         as addresses name this server
  /// @param certificate  of this server, whose names are its own; null: HTTP on the loopback
  ///                     address, with loopback's names
  Entrance(std::string host, int port, const X509* certificate);

  /// Whether its certificate, if any, is for its host.
  bool knows_itself() const { return is_own_name(host_ + port_); }
  /// Whether a value of the header Host names this server.
  bool is_own_name(const std::string& host) const;
  /// An address that opens the dashboard once.
  std::string address();

  /// What a request brings; empty where it has none of it.
  struct Visit {
    /// Values of the headers Host, Origin and Cookie, and of the key in the address.
    std::string host, origin, cookies, key;
    bool changes = false;  ///< its method is other than GET
    bool is_first_page = false;
  };
  /// Whether a request is let in, and what its reply must carry.
  struct Decision {
    bool admitted = false;
    std::string refusal{};  ///< why not; empty with `cookie`
    std::string cookie{};   ///< for Set-Cookie: the key was good
  };
  /// Judges a request. A key is used up by its first visit.
  Decision decide(const Visit& visit);

private:
  /// Whether the key is good; it is not afterwards.
  bool take_key(const std::string& key);
  /// Origin of the pages, as browsers send it.
  std::string origin() const;
  /// Name of the session's cookie, which contains the port.
  std::string cookie_name() const;

  const std::string host_;
  const std::string port_;  // ":7300"
  const X509* const certificate_;
  /// Value of the session's cookie: random, never stored.
  const std::string session_;
  std::mutex mutex_;
  /// Keys that have not been used.
  std::set<std::string> keys_;
};

}  // namespace dccast::client
