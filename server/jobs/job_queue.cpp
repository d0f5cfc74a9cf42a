#include "server/jobs/job_queue.hpp"

#include <algorithm>

#include "server/jobs/events.hpp"

namespace dccast::jobs {

namespace {

int level(v1::Priority priority) {
  return priority == v1::HIGH ? 2 : priority == v1::LOW ? 0 : 1;
}

}  // namespace

void JobQueue::push(const v1::Job& job, bool goes_first) {
  const std::int64_t by_age =
      milliseconds(job.create_time()) - level(job.priority()) * priority_bonus_ms;
  const std::int64_t key = goes_first ? first_key : by_age;
  if (key_of_.emplace(job.id(), key).second) order_.insert({key, job.id()});
}

void JobQueue::erase(const std::string& job_id) {
  const auto found = key_of_.find(job_id);
  if (found == key_of_.end()) return;
  order_.erase({found->second, job_id});
  key_of_.erase(found);
}

std::optional<std::string> JobQueue::front() const {
  if (order_.empty()) return std::nullopt;
  return order_.begin()->second;
}

int JobQueue::position(const std::string& job_id) const {
  const auto found = key_of_.find(job_id);
  if (found == key_of_.end()) return 0;
  return static_cast<int>(order_.order_of_key({found->second, job_id})) + 1;
}

namespace {

// A fault that comes back at once, such as a worker program that is not there, is tried less and
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
