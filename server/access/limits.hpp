#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>

namespace dccast::access {

/// A token bucket: a rate, and a number that is permitted at once.
class Allowance {
public:
  using Time = std::chrono::steady_clock::time_point;
  constexpr Allowance(double per_s, double at_once)
      : per_s_(per_s), at_once_(at_once), left_(at_once) {}
  /// @return whether so many more are permitted now; if not, none is taken
  bool take(Time now, double count = 1.0);
  bool is_full(Time now) const { return available(now) >= at_once_; }

private:
  double available(Time now) const;

  double per_s_, at_once_, left_;
  Time last_{};
};

/// Limits the rate of calls of each user, by a bucket that holds the calls of ten seconds. Safe to
/// use from several threads.
class CallRate {
public:
  using Time = Allowance::Time;
  explicit CallRate(double per_s) : per_s_(per_s) {}
  double per_s() const { return per_s_; }
  /// @return whether one more call of a user is permitted now
  bool take(const std::string& user, Time now);

private:
  const double per_s_;
  std::mutex mutex_;
  std::map<std::string, Allowance> buckets_;
};

/// Counts open objects, in total and for each user. Safe to use from several threads.
class OpenCount {
public:
  OpenCount(std::size_t limit, std::size_t limit_per_user)
      : limit_(limit), limit_per_user_(limit_per_user) {}
  /// Counts one more, until leave(). @param kind  in the plural, as in the name of the setting
  /// @throws refusal::LimitReached
  void enter(const std::string& user, const std::string& kind);
  void leave(const std::string& user);
  std::size_t open();

private:
  const std::size_t limit_;
  const std::size_t limit_per_user_;
  std::mutex mutex_;
  std::size_t total_ = 0;
  std::map<std::string, std::size_t> by_user_;
};

}  // namespace dccast::access
