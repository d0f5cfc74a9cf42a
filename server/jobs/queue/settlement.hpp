#pragma once

#include <cstdint>
#include <string>

#include "dccast/v1/job.pb.h"
#include "server/jobs/executors/executor.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::jobs {

/// Outcome of an attempt: the next state of its job.
struct Settlement {
  v1::JobState state = v1::QUEUED;  ///< QUEUED: it waits again and continues from its checkpoint
  std::string cause;                ///< one line for the user
  std::string daemon_lacks{};       ///< a resource whose lack must hold the queue; empty: none
};

/// Input of a settlement: what is known of the attempt.
struct AttemptFacts {
  /// Facts that the outcome depends on, besides log and exit.
  bool shutting_down = false;
  int worker_restarts = 2;
  v1::OtherVersion other_version = v1::BEGIN_ANEW;
  int storage_failures = 0;  ///< consecutive attempts that a failed write ended, without progress
  std::int64_t reached_step = 0;   ///< last step reported, or that of its checkpoint
  double reached_time = 0.0;       ///< [s]
  std::string hung{};              ///< why the worker was killed as hanging; empty: it was not
  std::string over_time{};         ///< its run time if that exceeds the limit; empty: it does not
  std::string unfed{};             ///< how long no reading came, if it was stopped for that
  std::string missing_artifact{};  ///< a result that the end of the run names but the disk lacks
  std::string storage_error{};     ///< why nothing can be written into the folder; empty: it can
  std::string damage{};            ///< of the job's own files, which no other job has; empty: none
};

/// The worker has recorded the end of its run. Sets failure, artifacts and requested action.
Settlement settle_run_end(JobRecord& record, const v1::RunEnd& end, const AttemptFacts& facts);

/// The attempt was stopped on request, or never began. The request decides the outcome; without one
/// the job waits again.
/// @param cause  why it waits, for the user
Settlement settle_stopped(JobRecord& record, const std::string& cause);

/// The worker died during its run.
Settlement settle_lost(JobRecord& record, const WorkerExit& exit, const AttemptFacts& facts);

}  // namespace dccast::jobs
