#include "client/web/user_channels.hpp"

#include <algorithm>

namespace dccast::client {
namespace {

/// An address as gRPC writes it. Without a port: browsers use many.
std::string written(const std::string& address) {
  return address.find(':') == std::string::npos ? "ipv4:" + address + ":0"
                                                : "ipv6:%5B" + address + "%5D:0";
}

}  // namespace

Connection UserChannels::connection(const std::string& token, const std::string& address) {
  const std::lock_guard lock(mutex_);
  const std::pair key{token, address};
  auto found = kept_.find(key);
  if (found == kept_.end()) {
    if (kept_.size() >= most_kept)
      kept_.erase(
          std::ranges::min_element(kept_, {}, [](const auto& entry) { return entry.second.used; }));
    Connection made({.address = server_, .token = token, .browser = written(address)});
    found = kept_.emplace(key, Kept{std::move(made), 0}).first;
  }
  found->second.used = ++uses_;
  return found->second.connection.another(std::make_shared<Interruption>());
}

}  // namespace dccast::client
