#pragma once

#include <chrono>
#include <cstdint>
#include <ext/pb_ds/assoc_container.hpp>
#include <ext/pb_ds/tree_policy.hpp>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// The order in which queued jobs start: by priority, then age. Each level of priority is worth
/// half an hour of waiting, so that a low job cannot wait forever behind a stream of high ones.
/// As all jobs age alike, that makes a fixed key: the time of submission minus the bonus.
class JobQueue {
public:
  static constexpr std::int64_t priority_bonus_ms = 30 * 60 * 1000;

  /// @param goes_first  before all that do not
  void push(const v1::Job& job, bool goes_first = false);
  void erase(const std::string& job_id);
  /// The next job. @return nothing when none waits
  std::optional<std::string> front() const;
  bool front_goes_first() const { return !order_.empty() && order_.begin()->first == first_key; }
  std::size_t size() const { return order_.size(); }
  /// 1 is next; 0: not in the queue. Takes the logarithm of the queue's length.
  int position(const std::string& job_id) const;

private:
  static constexpr std::int64_t first_key = INT64_MIN;
  using Place = std::pair<std::int64_t, std::string>;
  /// A set that knows how many are before an element.
  using Order = __gnu_pbds::tree<Place, __gnu_pbds::null_type, std::less<>, __gnu_pbds::rb_tree_tag,
                                 __gnu_pbds::tree_order_statistics_node_update>;
  Order order_;
  std::map<std::string, std::int64_t> key_of_;
};

/// Why no job is started now, and when to see whether that has passed. A hold is the daemon's own
/// fault, such as a full disk: it fails no job.
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
