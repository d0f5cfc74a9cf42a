#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace dccast::jobs {

/// Why no job is started now, and when to see whether that has passed. A hold is the daemon's own
/// trouble, such as a full disk: it fails no job.
class QueueHold {
public:
  using Clock = std::chrono::steady_clock;

  /// Holds the queue; the first reason is kept until the hold is lifted. @return whether it is new
  bool set(const std::string& reason);
  void lift();
  bool holds() const { return reason_.has_value(); }
  /// Empty when nothing holds the queue.
  std::string reason() const { return reason_.value_or(""); }
  /// When to look again.
  Clock::time_point next_look() const { return next_look_; }
  void look_again_later();

private:
  std::optional<std::string> reason_;
  Clock::time_point next_look_{};
  Clock::time_point lifted_{};
  Clock::duration interval_{};
};

}  // namespace dccast::jobs
