#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <string>

namespace dccast::relay {

/// What calls that were taken back cost those who began them. gRPC makes each call before it learns
/// that it is taken back, which takes it some tenths of a millisecond and a peer almost nothing. So
/// a peer waits longer for each than the server works for it, over all its connections together.
/// Used only by the relay thread.
class ResetToll {
public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::milliseconds of_each{4};
  /// Taken back at once without a wait: a client that leaves many calls may do so.
  static constexpr int free_at_once = 200;
  static constexpr std::chrono::seconds longest_wait{5};

  /// Charges an origin (Peer::origin()) for calls that were taken back.
  void charge(const std::string& origin, std::size_t resets, Clock::time_point now);
  /// When the connections of an origin may be read again; a time that has passed: at once.
  Clock::time_point paid_at(const std::string& origin) const;
  /// Whether no origin has to wait or will soon.
  bool is_empty() const { return paid_.empty(); }

private:
  /// When each origin has paid for all of its resets; less `free_at_once` of them are behind it.
  std::map<std::string, Clock::time_point> paid_;
};

}  // namespace dccast::relay
