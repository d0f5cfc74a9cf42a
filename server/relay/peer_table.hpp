#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace dccast::relay {

/// What the relay knows of the other end of a connection.
struct Peer {
  std::string host;       ///< "192.0.2.1"
  std::string address;    ///< as gRPC writes it: "ipv4:192.0.2.1:40000", "ipv6:%5B::1%5D:40000"
  bool over_tls = false;  ///< else from this machine
  std::optional<unsigned> user_id{};       ///< of this machine; nothing where it is not known
  std::string certificate_name{};          ///< verified; empty: none was shown
  std::int64_t certificate_ends_unix = 0;  ///< [s since 1970]
};

/// Header that names the connection of a call. The relay adds it behind what the client has sent. A
/// client may send the same header, and may let its last one swallow the relay's: it never learns
/// the name of a connection, though, and a call without one is refused.
inline constexpr const char* connection_header = "dccast-connection";

/// The peers of open connections by the name of their connection: 128 random bits as text. Safe to
/// use from several threads.
class PeerTable {
public:
  /// @return the name of the connection
  std::string add(std::shared_ptr<const Peer> peer);
  void remove(const std::string& connection);

  /// @return null: the connection has ended, or there was none of this name
  std::shared_ptr<const Peer> find(const std::string& connection) const;

  /// Notes whose calls come over a connection, once a call has shown a token.
  void set_user(const std::string& connection, const std::string& user);
  /// Whose calls come over a connection, by certificate, token or user id; empty: a stranger's.
  std::string user_of(const std::string& connection) const;

private:
  struct Entry {
    std::shared_ptr<const Peer> peer;
    std::string user;
  };

  mutable std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

}  // namespace dccast::relay
