#include "server/relay/reset_toll.hpp"

#include <algorithm>

namespace dccast::relay {

namespace {

constexpr ResetToll::Clock::duration credit = ResetToll::free_at_once * ResetToll::of_each;

}  // namespace

void ResetToll::charge(const std::string& origin, std::size_t resets, Clock::time_point now) {
  std::erase_if(paid_, [&](const auto& entry) { return entry.second <= now - credit; });

  const auto cost = static_cast<Clock::duration::rep>(resets) * Clock::duration(of_each);
  auto& paid = paid_.try_emplace(origin, now - credit).first->second;
  paid = std::min(paid + cost, now + Clock::duration(longest_wait));
}

ResetToll::Clock::time_point ResetToll::paid_at(const std::string& origin) const {
  const auto found = paid_.find(origin);
  return found == paid_.end() ? Clock::time_point() : found->second;
}

}  // namespace dccast::relay
