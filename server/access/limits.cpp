#include "server/access/limits.hpp"

#include <algorithm>

namespace dccast::access {

namespace {

constexpr double seconds_held = 10.0;
constexpr std::size_t most_buckets = 10000;  // then the full ones are forgotten

}  // namespace

double Allowance::left_at(Time now) const {
  if (last_ == Time{}) return left_;
  return std::min(at_once_, left_ + per_s_ * std::chrono::duration<double>(now - last_).count());
}

bool Allowance::take(Time now) {
  left_ = left_at(now);
  last_ = now;
  if (left_ < 1.0) return false;
  left_ -= 1.0;
  return true;
}

bool CallRate::take(const std::string& who, Time now) {
  const std::lock_guard guard(mutex_);
  if (buckets_.size() >= most_buckets)
    std::erase_if(buckets_, [&](const auto& one) { return one.second.is_full(now); });
  const double most = std::max(1.0, seconds_held * per_s_);
  return buckets_.try_emplace(who, per_s_, most).first->second.take(now);
}

std::string OpenCount::enter(const std::string& who, const std::string& what) {
  const std::lock_guard guard(mutex_);
  const auto at = of_.find(who);
  const std::size_t own = at == of_.end() ? 0 : at->second;
  if (own >= most_per_user_)
    return who + " has " + std::to_string(own) + " " + what + " open; maximum_" + what +
           "_per_user = " + std::to_string(most_per_user_);
  if (all_ >= most_)
    return std::to_string(all_) + " " + what + " of all users are open; maximum_" + what + " = " +
           std::to_string(most_);
  ++of_[who];
  ++all_;
  return "";
}

std::size_t OpenCount::open() {
  const std::lock_guard lock(mutex_);
  return all_;
}

void OpenCount::leave(const std::string& who) {
  const std::lock_guard guard(mutex_);
  const auto at = of_.find(who);
  if (at == of_.end()) return;
  --all_;
  if (--at->second == 0) of_.erase(at);
}

}  // namespace dccast::access
