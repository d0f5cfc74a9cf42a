#include "server/jobs/queue/job_queue.hpp"

#include <algorithm>
#include <cmath>

#include "server/jobs/folder/events.hpp"

namespace dccast::jobs {

JobQueue::Order& JobQueue::find_order(const Entry& entry) {
  return entry.lane == Lane::query ? first_ : orders_of(entry.lane)[entry.owner];
}

void JobQueue::push(const v1::Job& job, Lane lane) {
  const int level = job.priority() == v1::HIGH ? 2 : job.priority() == v1::LOW ? 0 : 1;
  const Entry entry{lane, job.owner(), milliseconds(job.create_time()) - level * priority_bonus_ms,
                    job.estimated_s()};

  if (!entries_.emplace(job.id(), entry).second) return;
  find_order(entry).insert({entry.key, job.id()});
  count_estimate(entry, 1);
}

void JobQueue::count_estimate(const Entry& entry, int change) {
  if (entry.estimated_s <= 0.0) return;
  estimated_s_ += change * entry.estimated_s;
  estimated_ += change;
}

void JobQueue::erase(const std::string& job_id) {
  const auto found = entries_.find(job_id);
  if (found == entries_.end()) return;

  const Entry& entry = found->second;
  find_order(entry).erase({entry.key, job_id});
  if (entry.lane != Lane::query && find_order(entry).empty())
    orders_of(entry.lane).erase(entry.owner);
  count_estimate(entry, -1);
  entries_.erase(found);
}

void JobQueue::charge(const std::string& owner, double seconds, std::int64_t at_ms) {
  if (half_life_.count() == 0) return;

  constexpr double longest_span = 500.0;  // [half-lives]; 2^500 is far below the largest double
  if (use_since_ms_ == 0) use_since_ms_ = at_ms;
  const auto half_lives_until = [this](std::int64_t time_ms) {
    return 1e-3 * static_cast<double>(time_ms - use_since_ms_) /
           static_cast<double>(half_life_.count());
  };

  if (half_lives_until(at_ms) > longest_span) {
    for (auto& [name, use] : use_) use = std::ldexp(use, -static_cast<int>(longest_span));
    use_since_ms_ += static_cast<std::int64_t>(longest_span) * 1000 * half_life_.count();
  }

  use_[owner] += seconds * std::exp2(half_lives_until(at_ms));
}

double JobQueue::past_use(const std::string& owner) const {
  const auto found = use_.find(owner);
  return found == use_.end() ? 0.0 : found->second;
}

bool JobQueue::is_before(const Orders::value_type& left, const Orders::value_type& right) const {
  return std::pair(past_use(left.first), *left.second.begin()) <
         std::pair(past_use(right.first), *right.second.begin());
}

const JobQueue::Orders::value_type* JobQueue::next_of(Lane lane, const MayStart& may_start) const {
  const Orders::value_type* next = nullptr;
  for (const auto& order : lane == Lane::followed ? followed_ : orders_)
    if ((!may_start || may_start(lane, order.first)) &&
        (next == nullptr || is_before(order, *next)))
      next = &order;
  return next;
}

std::optional<std::string> JobQueue::front(const MayStart& may_start) const {
  if (!first_.empty()) return first_.begin()->second;
  for (const Lane lane : {Lane::followed, Lane::job})
    if (const auto* next = next_of(lane, may_start)) return next->second.begin()->second;
  return std::nullopt;
}

int JobQueue::position(const std::string& job_id) const {
  const auto found = entries_.find(job_id);
  if (found == entries_.end()) return 0;

  const Entry& entry = found->second;
  if (entry.lane == Lane::query)
    return static_cast<int>(first_.order_of_key({entry.key, job_id})) + 1;

  // Owners take turns: of each other owner, as many jobs come first as of this one.
  const Orders& orders = entry.lane == Lane::followed ? followed_ : orders_;
  const auto own = orders.find(entry.owner);
  const std::size_t before_it = own->second.order_of_key({entry.key, job_id});
  std::size_t position = first_.size() + before_it + 1;

  for (const auto& other : orders)
    if (other.first != entry.owner && half_life_.count() == 0)
      position += other.second.order_of_key({entry.key, job_id});
    else if (other.first != entry.owner)
      position += std::min(other.second.size(), before_it + (is_before(other, *own) ? 1 : 0));

  return static_cast<int>(position);
}

}  // namespace dccast::jobs
