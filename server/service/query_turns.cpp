#include "server/service/query_turns.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "server/jobs/queue/tally.hpp"

namespace dccast::service {

using jobs::Urgency;

QueryTurns::QueryTurns(int at_once, const WaitingBound& bound) : at_once_(at_once) {
  for (const Urgency urgency :
       {Urgency::quick, Urgency::draft, Urgency::comparison, Urgency::long_query})
    of_urgency_.try_emplace(urgency, at_once, bound);
}

QueryWait QueryTurns::wait_in(const OneUrgency& queries) const {
  QueryWait wait{.running = static_cast<int>(queries.running.size()),
                 .ahead = static_cast<int>(queries.waiting_s.size())};

  // Time that each running query still needs, by its estimate.
  std::vector<double> left_s;
  for (const Running& run : queries.running) {
    const std::chrono::duration<double> ran = Clock::now() - run.begin;
    left_s.push_back(std::max(0.0, run.estimated_s - ran.count()));
  }

  const double mean_s =
      wait.ahead == 0
          ? 0.0
          : std::accumulate(queries.waiting_s.begin(), queries.waiting_s.end(), 0.0) / wait.ahead;
  wait.expected_s = jobs::Forecast::start_s(std::move(left_s), at_once_, wait.ahead + 1, mean_s);
  return wait;
}

bool QueryTurns::post(Urgency urgency, double estimated_s, const OnWait& on_wait,
                      std::function<void()> work, std::size_t bytes) {
  OneUrgency& queries = of_urgency_.at(urgency);
  std::unique_lock lock(mutex_);
  const QueryWait wait = wait_in(queries);
  queries.waiting_s.push_back(estimated_s);
  const auto place = std::prev(queries.waiting_s.end());
  lock.unlock();

  // Reports without the lock: the listener sends a message.
  if (wait.running + wait.ahead >= at_once_) on_wait(wait);

  const auto run = [this, &queries, place, estimated_s, work = std::move(work)] {
    std::unique_lock run_lock(mutex_);
    queries.waiting_s.erase(place);
    queries.running.push_back({estimated_s, Clock::now()});
    const auto running = std::prev(queries.running.end());
    run_lock.unlock();

    work();

    run_lock.lock();
    queries.running.erase(running);
  };
  if (queries.pool.post(run, bytes)) return true;

  lock.lock();
  queries.waiting_s.erase(place);
  return false;
}

}  // namespace dccast::service
