#include "server/relay/peer_table.hpp"

#include <fmt/format.h>

#include <utility>

#include "proto/values/digests.hpp"

namespace dccast::relay {

namespace {

/// The user as far as the connection identifies it, before a call presents a token.
std::string first_user(const Peer& peer) {
  if (peer.over_tls) return peer.certificate_name;
  return peer.user_id ? fmt::format("user id {}", *peer.user_id) : "unknown local user";
}

}  // namespace

std::string PeerTable::add(std::shared_ptr<const Peer> peer) {
  constexpr std::size_t random_bytes = 16;
  std::string connection = values::random_hexadecimal(random_bytes);
  std::string user = first_user(*peer);

  const std::lock_guard lock(mutex_);
  entries_.emplace(connection, Entry{std::move(peer), std::move(user)});
  return connection;
}

void PeerTable::remove(const std::string& connection) {
  const std::lock_guard lock(mutex_);
  entries_.erase(connection);
}

std::shared_ptr<const Peer> PeerTable::find(const std::string& connection) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(connection);
  return found == entries_.end() ? nullptr : found->second.peer;
}

void PeerTable::set_user(const std::string& connection, const std::string& user) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(connection);
  if (found != entries_.end()) found->second.user = user;
}

std::string PeerTable::user_of(const std::string& connection) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(connection);
  return found == entries_.end() ? "" : found->second.user;
}

}  // namespace dccast::relay
