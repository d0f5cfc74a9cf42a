#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>

namespace dccast::access {

/// So many a second, and a number at once.
class Allowance {
public:
  using Time = std::chrono::steady_clock::time_point;
  constexpr Allowance(double per_s, double at_once)
      : per_s_(per_s), at_once_(at_once), left_(at_once) {}
  /// @return whether one more is permitted now
  bool take(Time now);
  bool is_full(Time now) const { return left_at(now) >= at_once_; }

private:
  double left_at(Time now) const;

  double per_s_, at_once_, left_;
  Time last_{};
};

/// So many calls a second, each user on its own: a bucket that holds ten seconds' worth. Safe to
/// use from several threads.
class CallRate {
public:
  using Time = Allowance::Time;
  explicit CallRate(double per_s) : per_s_(per_s) {}
  double per_s() const { return per_s_; }
  /// @return whether one more call of `who` is permitted now
  bool take(const std::string& who, Time now);

private:
  const double per_s_;
  std::mutex mutex_;
  std::map<std::string, Allowance> buckets_;
};

/// How many of something are open, in all and for each user. Safe to use from several threads.
class OpenCount {
public:
  OpenCount(std::size_t most, std::size_t most_per_user)
      : most_(most), most_per_user_(most_per_user) {}
  /// @return which limit refuses one more; empty where it was counted, until leave()
  std::string enter(const std::string& who, const std::string& what);
  void leave(const std::string& who);
  std::size_t open();

private:
  const std::size_t most_, most_per_user_;
  std::mutex mutex_;
  std::size_t all_ = 0;
  std::map<std::string, std::size_t> of_;
};

}  // namespace dccast::access
