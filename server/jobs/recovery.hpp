#pragma once

#include <filesystem>
#include <vector>

#include "server/jobs/event_logs.hpp"
#include "server/jobs/executor.hpp"
#include "server/jobs/job_store.hpp"
#include "server/jobs/ledger.hpp"

namespace dccast::jobs {

/// Puts in order what the last daemon left, before anything else happens: no worker of it is left,
/// store and event logs agree. @return the jobs that wait
/// @throws StoreError
std::vector<v1::Job> recover_jobs(JobStore& store, EventLogs& logs, Ledger& ledger,
                                  Executor& executor);

}  // namespace dccast::jobs
