#pragma once

#include <string>
#include <vector>

#include "server/jobs/attempts.hpp"
#include "server/jobs/event_logs.hpp"
#include "server/jobs/executor.hpp"
#include "server/jobs/job_store.hpp"
#include "server/jobs/ledger.hpp"

namespace dccast::jobs {

/// What the last daemon left to do.
struct RecoveredJobs {
  std::vector<v1::Job> waiting;
  std::vector<JobRecord> with_worker;  ///< whose workers were found again and go on
  std::string daemon_lacks;            ///< why something could not be written; empty: all was
};

/// Puts in order what the last daemon left, before anything else happens: jobs whose workers have
/// ended meanwhile become what their folders have. @throws StoreError
RecoveredJobs recover_jobs(const AttemptOptions& options, JobStore& store, EventLogs& logs,
                           Ledger& ledger, Executor& executor);

}  // namespace dccast::jobs
