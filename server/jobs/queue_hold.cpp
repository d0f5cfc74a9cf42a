#include "server/jobs/queue_hold.hpp"

#include <algorithm>

namespace dccast::jobs {

namespace {

// A trouble that comes back at once, such as a worker program that is not there, is tried less and
// less often.
constexpr QueueHold::Clock::duration shortest_interval = std::chrono::seconds(1);
constexpr QueueHold::Clock::duration longest_interval = std::chrono::seconds(30);

}  // namespace

bool QueueHold::set(const std::string& reason) {
  if (holds()) return false;
  const bool came_back = Clock::now() - lifted_ < 2 * shortest_interval;
  interval_ = came_back ? std::min(2 * interval_, longest_interval) : shortest_interval;
  reason_ = reason;
  look_again_later();
  return true;
}

void QueueHold::lift() {
  reason_.reset();
  lifted_ = Clock::now();
}

void QueueHold::look_again_later() {
  next_look_ = Clock::now() + interval_;
}

}  // namespace dccast::jobs
