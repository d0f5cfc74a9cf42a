#pragma once

#include <filesystem>
#include <string>

#include "server/jobs/job_description.hpp"
#include "server/jobs/job_store.hpp"

namespace dccast::state {

/// Brings a record to what the job's event log says: state, attempts, times, failure, artifacts. An
/// event is always written before the store is, so the log is never behind. The log is only read.
/// @throws std::runtime_error  the log cannot be read
void bring_up_to_log(jobs::JobRecord& record, const std::filesystem::path& log);

/// Takes a folder of `jobs/` into the store, in the state its event log ends with.
/// @throws std::runtime_error  it cannot be taken; the text is the reason
void adopt(jobs::JobStore& store, const std::filesystem::path& folder);

/// Where a row contradicts the description in the job's folder: SQLite has no checksum over what a
/// row holds, the description has one. @return the name of the first such field; empty for none
std::string contradiction(jobs::JobStore& store, const jobs::JobRecord& record,
                          const jobs::JobDescription& description);

}  // namespace dccast::state
