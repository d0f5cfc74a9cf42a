#include "server/relay/peer_table.hpp"

#include <charconv>
#include <utility>

namespace dccast::relay {

std::uint64_t PeerTable::add(std::shared_ptr<const Peer> peer) {
  const std::lock_guard lock(mutex_);
  peers_.emplace(++last_, std::move(peer));
  return last_;
}

void PeerTable::remove(std::uint64_t connection) {
  const std::lock_guard lock(mutex_);
  peers_.erase(connection);
}

std::shared_ptr<const Peer> PeerTable::find(std::string_view connection) const {
  std::uint64_t number = 0;
  std::from_chars(connection.data(), connection.data() + connection.size(), number);

  const std::lock_guard lock(mutex_);
  const auto found = peers_.find(number);
  return found == peers_.end() ? nullptr : found->second;
}

}  // namespace dccast::relay
