#pragma once

#include <chrono>
#include <compare>
#include <condition_variable>
#include <map>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "server/studies/run_results.hpp"

namespace dccast::studies {

/// Makes jobs of the runs of studies: one thread, a few runs of each study at a time, so that a
/// thousand runs neither fill the queue nor delay later jobs. The store records the progress; after
/// an interruption the last run is repeated, which gives the same job.
class StudyFeeder {
public:
  /// Both outlive this object.
  StudyFeeder(StudiesState& state, RunResults& results) : state_(state), results_(results) {}

  /// Starts and ends the thread.
  void start();
  void stop();
  /// Makes the feeder look again soon.
  void wake();

  /// Queues one run of a study if it has room; only the feeder's thread and tests call it.
  /// @return whether another look may queue more @throws std::exception  nothing can be queued now
  bool feed(const std::string& id);

private:
  /// A run of a study.
  struct RunName {
    std::string study;
    int number = 0;

    auto operator<=>(const RunName&) const = default;
  };

  /// The loop: feeds every study that has runs to queue, then waits for a change.
  void run(const std::stop_token& stop);
  /// Waits until it is woken, at most for this time.
  void wait(const std::stop_token& stop, std::chrono::steady_clock::duration most);
  /// Makes the job of one run, or refuses the run where its case is rejected.
  void queue_run(const StudyRecord& study, const RunRecord& run, const PlannedRun& planned);
  /// Queues the next run of a growing plan, or drops it if the plan is finished. The run waits from
  /// the moment the one before it is queued, so that the study does not end in between.
  /// @return false: a run on which it depends has not ended
  bool queue_next_run(const StudyRecord& study, const StudyPlan& plan, const RunRecord& run);
  /// Does nothing if the run has been cancelled meanwhile.
  void make_job(const StudyRecord& study, RunRecord run, const std::string& key, jobs::NewJob job);
  /// Marks a run as failed without a job, because its case was rejected.
  void refuse(const StudyRecord& study, RunRecord run, const std::string& why);

  StudiesState& state_;
  RunResults& results_;
  std::mutex mutex_;  ///< guards woken_
  std::condition_variable_any changed_;
  bool woken_ = true;
  std::map<RunName, int> crashed_checks_;  ///< checks of a run that a worker did not survive
  std::jthread thread_;
};

}  // namespace dccast::studies
