#pragma once

#include <chrono>
#include <cstddef>

namespace dccast::relay {

/// Budget of one connection for one turn of the relay thread: bytes, transfers of a socket, and
/// time. A peer decides how much work waits in its socket; the budget decides how much of it is
/// done before other connections have their turn.
class TurnBudget {
public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::size_t most_bytes = 512 * 1024;
  /// A record of TLS takes two: its head and its content.
  static constexpr std::size_t most_transfers = 128;
  /// With all connections of a listener busy, a turn comes every second.
  static constexpr std::chrono::microseconds most_time{1000};

  /// Begins a turn.
  void begin(Clock::time_point now) {
    bytes_ = transfers_ = 0;
    end_ = now + most_time;
  }

  /// Counts one transfer of so many bytes over a socket.
  void spend(std::size_t bytes) {
    bytes_ += bytes;
    ++transfers_;
  }

  /// Whether others go first. The first transfer of a turn is always permitted.
  bool is_spent(Clock::time_point now) const {
    if (transfers_ == 0) return false;
    return bytes_ >= most_bytes || transfers_ >= most_transfers || now >= end_;
  }

private:
  std::size_t bytes_ = 0, transfers_ = 0;
  Clock::time_point end_{};
};

}  // namespace dccast::relay
