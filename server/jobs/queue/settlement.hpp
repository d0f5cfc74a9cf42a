#pragma once

#include <cstdint>
#include <string>

#include "dccast/v1/job.pb.h"
#include "server/jobs/executors/executor.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::jobs {

/// What a job becomes when its worker has left it.
struct Settlement {
  v1::JobState state = v1::QUEUED;  ///< QUEUED: it waits again and goes on from its checkpoint
  std::string cause;                ///< one line for people
  std::string daemon_lacks{};       ///< why nothing else should start now; empty: no reason
};

/// What is known of an attempt when its job is settled.
struct AttemptFacts {
  bool shutting_down = false;
  int worker_restarts = 2;
  v1::OtherVersion other_version = v1::BEGIN_ANEW;
  int storage_failures = 0;       ///< attempts in a row that were ended by it and got no further
  std::int64_t reached_step = 0;  ///< last one reported, or that of the checkpoint it went on from
  double reached_time = 0.0;      ///< [s]
  std::string hung{};             ///< why the worker was taken to hang; empty: it was not
  std::string over_time{};        ///< how long it has run, where that is too long; empty: it is not
  std::string
      missing_artifact{};  ///< a result that is not on the disk although the run's end names it
  std::string storage_error{};  ///< why the folder of the job takes nothing; empty: it does
};

/// The worker has left its run in good order. Fills in failure, artifacts and what was requested.
Settlement settle_run_end(JobRecord& record, const v1::RunEnd& end, const AttemptFacts& facts);

/// The attempt was stopped by order, or never began: what was requested decides; without a request
/// the job waits again.
/// @param cause  why it waits, for people
Settlement settle_stopped(JobRecord& record, const std::string& cause);

/// The worker died in the middle of its run.
Settlement settle_lost(JobRecord& record, const WorkerExit& exit, const AttemptFacts& facts);

}  // namespace dccast::jobs
