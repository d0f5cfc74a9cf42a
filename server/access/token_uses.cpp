#include "server/access/token_uses.hpp"

#include <algorithm>
#include <utility>

namespace dccast::access {

void TokenUses::note(const std::string& id, TokenUse use) {
  const std::lock_guard guard(mutex_);
  if (uses_.size() >= most_kept && !uses_.contains(id))
    uses_.erase(
        std::ranges::min_element(uses_, {}, [](const auto& entry) { return entry.second.unix_s; }));
  uses_[id] = std::move(use);
}

std::optional<TokenUse> TokenUses::last(const std::string& id) {
  const std::lock_guard guard(mutex_);
  const auto found = uses_.find(id);
  return found == uses_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace dccast::access
