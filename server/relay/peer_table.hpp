#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

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

/// Header that names the connection of a call. The relay adds it behind what the client has sent.
inline constexpr const char* connection_header = "dccast-connection";

/// The peers of open connections by the number of their connection, which is never used again.
/// Safe to use from several threads.
class PeerTable {
public:
  /// @return the number of the connection
  std::uint64_t add(std::shared_ptr<const Peer> peer);
  void remove(std::uint64_t connection);

  /// @param connection  value of the connection header
  /// @return            null: the connection has ended
  std::shared_ptr<const Peer> find(std::string_view connection) const;

  /// Notes whose calls come over a connection, once a call has shown a token.
  /// @param connection  value of the connection header
  void set_user(std::string_view connection, const std::string& user);
  /// Whose calls come over a connection, by certificate, token or user id; empty: a stranger's.
  std::string user_of(std::uint64_t connection) const;

private:
  struct Entry {
    std::shared_ptr<const Peer> peer;
    std::string user;
  };

  mutable std::mutex mutex_;
  std::uint64_t last_ = 0;
  std::map<std::uint64_t, Entry> entries_;
};

}  // namespace dccast::relay
