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
#include "server/jobs/queue/lane.hpp"

namespace dccast::jobs {

/// The order in which queued jobs start. Owners share the processors: the next job belongs to the
/// owner with the least use of them, where older use counts less. Jobs of one owner are ordered by
/// priority and age. Each level of priority is worth half an hour of waiting, so that a low job
/// cannot wait forever behind a stream of high ones. All jobs age alike, so the key is fixed: the
/// time of submission minus the bonus.
class JobQueue {
public:
  /// Whether an owner may have one more job of a lane running; not asked for Lane::query.
  using MayStart = std::function<bool(Lane lane, const std::string& owner)>;

  /// Half an hour for each level [ms].
  static constexpr std::int64_t priority_bonus_ms = 30 * 60 * 1000;
  /// Charged for a job at its start, until its use is known [s].
  static constexpr double start_charge_s = 60.0;

  /// @param half_life  of past use; 0: owners do not share, one order for all jobs
  explicit JobQueue(std::chrono::seconds half_life = std::chrono::hours(24))
      : half_life_(half_life) {}

  void push(const v1::Job& job, Lane lane = Lane::job);
  /// Removes a job that was started or cancelled; others keep their order.
  void erase(const std::string& job_id);
  /// Counts processor seconds for an owner. @param at_ms  when they were used, since 1970
  void charge(const std::string& owner, double seconds, std::int64_t at_ms);
  /// The next job: queries before castings that are followed, and these before others.
  /// @return nothing if none waits that may start
  std::optional<std::string> front(const MayStart& may_start = {}) const;
  /// The lane of a job in the queue.
  Lane lane_of(const std::string& job_id) const { return entries_.at(job_id).lane; }
  std::size_t size() const { return entries_.size(); }
  /// Mean estimate of the waiting jobs that have one [s]; 0: none has.
  double mean_estimated_s() const { return estimated_ == 0 ? 0.0 : estimated_s_ / estimated_; }
  /// Position of a job: 1 is next, 0: not in the queue. With several owners it assumes that all
  /// jobs take the same time. The cost for each owner is logarithmic in the length of the queue.
  int position(const std::string& job_id) const;

private:
  /// Time of submission minus the bonus [ms], then the id, so that no two are equal.
  using Key = std::pair<std::int64_t, std::string>;
  /// A set that counts the elements before a given one.
  using Order = __gnu_pbds::tree<Key, __gnu_pbds::null_type, std::less<>, __gnu_pbds::rb_tree_tag,
                                 __gnu_pbds::tree_order_statistics_node_update>;
  /// A queued job with what orders it.
  struct Entry {
    Lane lane;
    std::string owner;
    std::int64_t key;
    double estimated_s;
  };
  /// Queued jobs by owner.
  using Orders = std::map<std::string, Order>;
  /// The orders of a lane by owner.
  Orders& orders_of(Lane lane) { return lane == Lane::followed ? followed_ : orders_; }
  /// The order that an entry belongs to, made if it is the owner's first.
  Order& find_order(const Entry& entry);
  /// The order whose first job is next of a lane; null if none may start.
  const Orders::value_type* next_of(Lane lane, const MayStart& may_start) const;
  /// Adds an estimate to the mean, or takes it out. @param change  +1 or -1
  void count_estimate(const Entry& entry, int change);
  /// Use of an owner, in which later use counts more; 0 if there was none.
  double past_use(const std::string& owner) const;
  /// Whether a job of this owner is taken before one of the other.
  bool is_before(const Orders::value_type& left, const Orders::value_type& right) const;

  const std::chrono::seconds half_life_;
  Order first_;               ///< of Lane::query
  Orders followed_, orders_;  ///< by owner; none is empty
  std::map<std::string, Entry> entries_;
  double estimated_s_ = 0.0;  ///< of all that have an estimate
  int estimated_ = 0;         ///< their number
  /// By owner, relative to `use_since_ms_`: later use counts more, so that nothing has to decay.
  std::map<std::string, double> use_;
  std::int64_t use_since_ms_ = 0;
};

}  // namespace dccast::jobs
