#include "server/access/limits.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <string>

#include "proto/refusal/refusal.hpp"

namespace dccast::access {

namespace {

constexpr double seconds_held = 10.0;
constexpr std::size_t largest_number_of_buckets = 10000;  // beyond it, full buckets are dropped

}  // namespace

double Allowance::available(Time now) const {
  if (last_ == Time{}) return left_;
  return std::min(at_once_, left_ + per_s_ * std::chrono::duration<double>(now - last_).count());
}

bool Allowance::take(Time now, double count) {
  left_ = available(now);
  last_ = now;
  if (left_ < count) return false;
  left_ -= count;
  return true;
}

bool CallRate::take(const std::string& user, Time now) {
  const std::lock_guard guard(mutex_);
  if (buckets_.size() >= largest_number_of_buckets)
    std::erase_if(buckets_, [&](const auto& entry) { return entry.second.is_full(now); });
  const double most = std::max(1.0, seconds_held * per_s_);
  return buckets_.try_emplace(user, per_s_, most).first->second.take(now);
}

void OpenCount::enter(const std::string& user, const std::string& kind) {
  const std::lock_guard guard(mutex_);
  const auto found = by_user_.find(user);
  const std::size_t own = found == by_user_.end() ? 0 : found->second;
  if (own >= limit_per_user_)
    throw refusal::LimitReached({.cause = fmt::format("{} has {} {} open", user, own, kind),
                                 .limit = fmt::format("per_user.maximum_{}", kind),
                                 .permitted = std::to_string(limit_per_user_),
                                 .remedy = "end one, then try again"});
  if (total_ >= limit_)
    throw refusal::LimitReached({.cause = fmt::format("{} {} of all users are open", total_, kind),
                                 .limit = fmt::format("limits.maximum_{}", kind),
                                 .permitted = std::to_string(limit_),
                                 .remedy = "end one, then try again"});

  ++by_user_[user];
  ++total_;
}

std::size_t OpenCount::open() {
  const std::lock_guard lock(mutex_);
  return total_;
}

void OpenCount::leave(const std::string& user) {
  const std::lock_guard guard(mutex_);
  const auto found = by_user_.find(user);
  if (found == by_user_.end()) return;

  --total_;
  if (--found->second == 0) by_user_.erase(found);
}

}  // namespace dccast::access
