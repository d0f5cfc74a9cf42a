#include "server/relay/peer_table.hpp"

#include <fmt/format.h>

#include <charconv>
#include <utility>

namespace dccast::relay {

namespace {

std::uint64_t number_in(std::string_view connection) {
  std::uint64_t number = 0;
  std::from_chars(connection.data(), connection.data() + connection.size(), number);
  return number;
}

/// What is known before a call shows a token.
std::string first_user(const Peer& peer) {
  if (peer.over_tls) return peer.certificate_name;
  return peer.user_id ? fmt::format("user id {}", *peer.user_id) : "unknown local user";
}

}  // namespace

std::uint64_t PeerTable::add(std::shared_ptr<const Peer> peer) {
  const std::lock_guard lock(mutex_);
  std::string user = first_user(*peer);
  entries_.emplace(++last_, Entry{std::move(peer), std::move(user)});
  return last_;
}

void PeerTable::remove(std::uint64_t connection) {
  const std::lock_guard lock(mutex_);
  entries_.erase(connection);
}

std::shared_ptr<const Peer> PeerTable::find(std::string_view connection) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(number_in(connection));
  return found == entries_.end() ? nullptr : found->second.peer;
}

void PeerTable::set_user(std::string_view connection, const std::string& user) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(number_in(connection));
  if (found != entries_.end()) found->second.user = user;
}

std::string PeerTable::user_of(std::uint64_t connection) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(connection);
  return found == entries_.end() ? "" : found->second.user;
}

}  // namespace dccast::relay
