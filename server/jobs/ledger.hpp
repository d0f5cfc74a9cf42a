#pragma once

#include <map>
#include <optional>
#include <string>

#include "server/jobs/event_logs.hpp"
#include "server/jobs/job_store.hpp"

namespace dccast::jobs {

/// What every job is. A transition is written to the job's event log first, then to the store, then
/// as one line with its cause to the program's log. The event log is the truth: what the store does
/// not take is kept here and written again until it does.
///
/// Not safe to use from several threads: the scheduler's mutex guards it.
class Ledger {
public:
  Ledger(JobStore& store, EventLogs& logs) : store_(store), logs_(logs) {}

  /// Brings a job into a state. When this throws, nothing has changed, neither `record` nor the
  /// disk.
  /// @throws std::exception  the event cannot be written
  void transition(JobRecord& record, v1::JobState to, const std::string& cause);

  /// A transition that has happened already, because a worker has left the job so: what the disk
  /// refuses now is kept, and written by retry(). A job whose own files are damaged fails.
  /// @return why it could not be written; empty when it was
  std::string settle(JobRecord& record, v1::JobState to, const std::string& cause);

  /// Writes what is kept. @return whether nothing is left
  bool retry();
  /// What the disk refused last, while something is kept; empty when nothing is.
  std::string trouble() const { return pending_.empty() ? "" : trouble_; }

  /// The job as it is: as kept here, or as stored. @throws StoreError
  std::optional<JobRecord> find(const std::string& id);
  /// The job as kept here; null when the store has all of it.
  const JobRecord* pending(const std::string& id) const;

private:
  struct Pending {
    JobRecord record;
    std::string cause;
    bool event_written = false;
  };
  void write_event(JobRecord& record, const std::string& cause);
  void write_store(const JobRecord& record, const std::string& cause, v1::JobState from);
  bool write(Pending& pending);
  void fail_for_damage(JobRecord& record, const std::string& why);

  JobStore& store_;
  EventLogs& logs_;
  std::map<std::string, Pending> pending_;  ///< by job
  std::string trouble_;
};

}  // namespace dccast::jobs
