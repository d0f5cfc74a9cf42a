#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/jobs/logs/event_logs.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::jobs {

using JobObserver = std::function<void(const v1::Job&)>;
/// Is called with a job as it is since it left the state `from`.
using TransitionObserver = std::function<void(const v1::Job& job, v1::JobState from)>;

/// What every job is. A transition is written to the job's event log, which is the truth, then to
/// the store, which is an index, then as one line with its cause to the program's log. What the
/// store does not take is kept here until it does.
///
/// Waits for the disk; the caller sees to it that one thread at a time changes a job.
class Ledger {
public:
  Ledger(JobStore& store, EventLogs& logs) : store_(store), logs_(logs) {}

  /// Brings a job into a state. Watchers see it after announce(). When this throws, nothing has
  /// changed, neither `record` nor what the folder of the job has.
  /// @throws std::exception  the event cannot be written
  void transition(JobRecord& record, v1::JobState to, const std::string& cause);
  /// The same where a job whose own files are damaged fails.
  /// @throws std::exception  the disk takes nothing now
  void settle(JobRecord& record, v1::JobState to, const std::string& cause);
  /// Takes a job for what it is without writing anything: the store gets it with retry().
  void keep(const JobRecord& record, const std::string& why);
  /// Has the observer called with every job that the store has in another state, or no more, by the
  /// thread that changed it: it must not wait, nor ask for a job. An empty one ends that; the last
  /// call has returned then.
  void observe(JobObserver observer);
  void report(const v1::Job& job);
  /// Has the observer called once for every transition from now on, under the same conditions.
  /// Before other threads use this object.
  void observe_transitions(TransitionObserver observer) {
    transition_observers_.push_back(std::move(observer));
  }
  /// Changes a job that the store has not taken yet, before the next try.
  void change_kept(const v1::Job& marks);
  /// Lets watchers see the last transition.
  void announce(const std::string& job_id);

  /// Writes what the store has refused. @return whether nothing is left
  bool retry();
  /// What the store refused last, while something is kept; empty when nothing is.
  std::string refusal() const;

  /// The job as it is. @throws StoreError
  std::optional<JobRecord> find(const std::string& id);
  /// The job as the store has not taken it yet.
  std::optional<JobRecord> kept(const std::string& id) const;

private:
  void write_event(JobRecord& record, const std::string& cause);
  void write_store(const JobRecord& record, const std::string& cause, v1::JobState from);

  JobStore& store_;
  EventLogs& logs_;
  std::vector<TransitionObserver> transition_observers_;
  std::mutex observer_mutex_;
  JobObserver observer_;
  mutable std::mutex mutex_;               ///< of all below
  std::map<std::string, JobRecord> kept_;  ///< by job
  std::string refusal_;
};

}  // namespace dccast::jobs
