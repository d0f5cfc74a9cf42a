#include "server/jobs/queue/tally.hpp"

#include <algorithm>
#include <functional>
#include <queue>

#include "server/jobs/folder/events.hpp"

namespace dccast::jobs {

void Histogram::add(double value) {
  ++count;
  sum += value;
  const auto bound = std::ranges::lower_bound(bounds, value);
  if (bound != bounds.end()) ++counts[static_cast<std::size_t>(bound - bounds.begin())];
}

void Tally::count(const v1::Job& job, v1::JobState from) {
  if (is_terminal(from)) return;
  const std::lock_guard lock(mutex_);
  if (job.state() == v1::RUNNING && job.attempts() == 1)
    figures_.wait_s.add(1e-3 *
                        static_cast<double>(std::max<std::int64_t>(
                            0, milliseconds(job.start_time()) - milliseconds(job.create_time()))));

  if (!is_terminal(job.state())) return;
  ++figures_.ended[job.state()];
  if (job.attempts() > 0) figures_.run_s.add(job.run_s());
  figures_.processor_s[job.owner()] += job.last_step().process_s();
  if (job.has_failure()) ++figures_.failures[job.failure().kind()];
  for (const v1::Finding& finding : job.findings())
    ++figures_.findings[{finding.code(), finding.severity()}];
}

TallyFigures Tally::figures() const {
  const std::lock_guard lock(mutex_);
  return figures_;
}

void Forecast::learn(const v1::Job& job) {
  constexpr double kept = 0.95;  // the mean covers some twenty jobs
  if (job.state() != v1::SUCCEEDED || job.run_s() <= 0.0) return;

  total_s_ = kept * total_s_ + job.run_s();
  weight_ = kept * weight_ + 1.0;
  if (job.estimated_s() <= 0.0) return;

  taken_s_ = kept * taken_s_ + job.run_s();
  estimated_s_ = kept * estimated_s_ + job.estimated_s();
}

double Forecast::run_s(double estimated_s) const {
  if (estimated_s > 0.0)
    return estimated_s_ > 0.0 ? estimated_s * taken_s_ / estimated_s_ : estimated_s;
  return weight_ > 0.0 ? total_s_ / weight_ : 0.0;
}

double Forecast::remaining_s(const v1::Job& job, double ran_s) const {
  constexpr double enough = 0.05;  // part of the run after which its own pace is known

  const double progress = job.last_step().progress();
  const double expected_s = run_s(job.estimated_s());

  // During the hold only heat is computed, which is quick: its pace is none for what follows. Later
  // the pace counts as much as it has been measured.
  const bool holds = job.last_step().time_s() < 0.0;
  if (progress < enough || ran_s <= 0.0 || (holds && expected_s > 0.0))
    return std::max(0.0, expected_s - ran_s);
  if (expected_s <= 0.0) return ran_s * (1.0 - progress) / progress;
  return (1.0 - progress) * ((1.0 - progress) * expected_s + ran_s);
}

double Forecast::start_s(std::vector<double> remaining_s, int capacity, int place, double each_s) {
  constexpr int longest_simulated = 200;  // beyond, the queue flows evenly
  std::priority_queue<double, std::vector<double>, std::greater<>> free_at(std::greater<>(),
                                                                           std::move(remaining_s));

  while (static_cast<int>(free_at.size()) < capacity) free_at.push(0.0);

  for (int i = 1; i < std::min(place, longest_simulated); ++i) {
    const double start = free_at.top();
    free_at.pop();
    free_at.push(start + each_s);
  }

  return free_at.top() + std::max(0, place - longest_simulated) * each_s / std::max(1, capacity);
}

}  // namespace dccast::jobs
