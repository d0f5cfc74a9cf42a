#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/jobs/logs/event_logs.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::jobs {

/// Called with a job after every change.
using JobObserver = std::function<void(const v1::Job&)>;
/// Called with a job after its transition from the state `from`.
using TransitionObserver = std::function<void(const v1::Job& job, v1::JobState from)>;

/// The states of all jobs. A transition is written to the job's event log, which is authoritative,
/// then to the store, which is an index, then as one line with its cause to the program's log.
/// While the store refuses a row, the folder of the job is read in its place.
///
/// Waits for the disk. The caller ensures that only one thread at a time changes a job.
class Ledger {
public:
  Ledger(JobStore& store, EventLogs& logs, std::filesystem::path jobs_directory)
      : store_(store), logs_(logs), jobs_directory_(std::move(jobs_directory)) {}

  /// Brings a job into a state. Watchers see it after announce(). If this throws, neither `record`
  /// nor the folder of the job has changed.
  /// @throws std::exception  the event cannot be written
  void transition(JobRecord& record, v1::JobState to, const std::string& cause);
  /// The same, but a job whose own files are damaged becomes FAILED.
  /// @throws std::exception  nothing can be written now
  void settle(JobRecord& record, v1::JobState to, const std::string& cause);
  /// Makes a job FAILED whose own files take no event of it: the store alone has its end.
  void fail_without_event(JobRecord& record, const std::string& why);
  /// Writes the row of a job whose folder has changed. If the store refuses, the row stays behind
  /// its folder until retry().
  void index(const JobRecord& record);
  /// Sets an observer of every job whose row has changed or was erased. It is called by the thread
  /// that changed the job, and must neither block nor read a job. An empty observer ends the calls;
  /// the last one has returned then.
  void observe(JobObserver observer);
  /// Passes a job on to the observers.
  void report(const v1::Job& job);
  /// Adds an observer that is called once for every transition, under the same conditions. To be
  /// called before other threads use this object.
  void observe_transitions(TransitionObserver observer) {
    transition_observers_.push_back(std::move(observer));
  }
  /// Shows the last transition to watchers.
  void announce(const std::string& job_id);

  /// Makes the rows that are behind again from their folders.
  /// @throws StoreError, std::system_error
  void retry();
  /// The last error of the store while a row is behind; empty if none is.
  std::string refusal() const;

  /// The present record of a job. @throws StoreError
  std::optional<JobRecord> find(const std::string& id);
  /// The present record of a job whose row was read.
  JobRecord present(JobRecord row);

private:
  /// Appends the transition to the event log. @throws std::exception  it cannot be written
  void write_event(JobRecord& record, const std::string& cause);
  /// Reports the transition and brings the row up to date.
  void write_store(const JobRecord& record, const std::string& cause, v1::JobState from);

  std::optional<JobRecord> read_or_fail(const std::string& id);

  JobStore& store_;
  EventLogs& logs_;
  const std::filesystem::path jobs_directory_;
  std::vector<TransitionObserver> transition_observers_;
  std::mutex observer_mutex_;
  JobObserver observer_;
  mutable std::mutex mutex_;      ///< guards all below
  std::set<std::string> behind_;  ///< jobs whose row is older than their folder
  std::string refusal_;
};

}  // namespace dccast::jobs
