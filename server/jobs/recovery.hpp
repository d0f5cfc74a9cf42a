#pragma once

#include <filesystem>
#include <vector>

#include "server/jobs/event_logs.hpp"
#include "server/jobs/executor.hpp"
#include "server/jobs/job_store.hpp"
#include "server/jobs/ledger.hpp"

namespace dccast::jobs {

/// What the last daemon left to do.
struct RecoveredJobs {
  std::vector<v1::Job> waiting;
  /// Jobs whose workers were found again: those that run go on, of the others the worker is to go.
  std::vector<JobRecord> with_worker;
};

/// Puts in order what the last daemon left, before anything else happens: the executor has looked
/// for its workers, store and event logs agree. @throws StoreError
RecoveredJobs recover_jobs(const std::filesystem::path& jobs_directory, JobStore& store,
                           EventLogs& logs, Ledger& ledger, Executor& executor);

}  // namespace dccast::jobs
