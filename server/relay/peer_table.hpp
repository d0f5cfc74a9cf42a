#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace dccast::relay {

/// Facts about the other end of a connection.
struct Peer {
  std::string host;       ///< "192.0.2.1"
  std::string address;    ///< as gRPC writes it: "ipv4:192.0.2.1:40000", "ipv6:%5B::1%5D:40000"
  bool over_tls = false;  ///< otherwise a client on this machine
  std::optional<unsigned> user_id{};       ///< on this machine; empty if unknown
  std::string certificate_name{};          ///< verified; empty if no certificate was presented
  std::int64_t certificate_ends_unix = 0;  ///< [s since 1970]

  /// Group of connections that share delays and a maximum: those of a local user, or of another
  /// machine.
  std::string origin() const { return user_id ? "user id " + std::to_string(*user_id) : host; }
};

/// Header that names the connection of a call, added by the relay after the client's own headers. A
/// client can send the same header, and can craft its last one so that it hides the relay's. But
/// clients never learn the name of a connection, and a call without a valid name is refused.
inline constexpr const char* connection_header = "dccast-connection";

/// Peers of open connections, by connection name (128 random bits as text). Safe to use from
/// several threads.
class PeerTable {
public:
  /// @return name of the connection
  std::string add(std::shared_ptr<const Peer> peer);
  /// Forgets a connection that has ended; calls that name it are refused from then on.
  void remove(const std::string& connection);

  /// @return null if no open connection has this name
  std::shared_ptr<const Peer> find(const std::string& connection) const;

  /// Stores the user of a connection once a call has presented a token.
  void set_user(const std::string& connection, const std::string& user);
  /// User of a connection, by certificate, token or user id; empty if unauthenticated.
  std::string user_of(const std::string& connection) const;

private:
  /// Peer and user of a connection; the user is empty until it is known.
  struct Entry {
    std::shared_ptr<const Peer> peer;
    std::string user;
  };

  mutable std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

}  // namespace dccast::relay
