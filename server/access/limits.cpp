#include "server/access/limits.hpp"

#include <algorithm>

namespace dccast::access {

namespace {

constexpr double seconds_held = 10.0;
constexpr std::size_t most_buckets = 10000;  // then the full ones are forgotten

}  // namespace

bool CallRate::take(const std::string& who, Time now) {
  const double most = std::max(1.0, seconds_held * per_s_);
  const std::lock_guard guard(mutex_);
  const auto left_at = [&](const Bucket& bucket) {
    const std::chrono::duration<double> passed = now - bucket.seen;
    return std::min(most, bucket.left + passed.count() * per_s_);
  };
  if (buckets_.size() >= most_buckets)
    std::erase_if(buckets_, [&](const auto& one) { return left_at(one.second) >= most; });
  const auto [at, is_new] = buckets_.try_emplace(who, Bucket{most, now});
  Bucket& bucket = at->second;
  bucket.left = left_at(bucket);
  bucket.seen = now;
  if (bucket.left < 1.0) return false;
  bucket.left -= 1.0;
  return true;
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
