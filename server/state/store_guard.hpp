#pragma once

#include <memory>
#include <set>
#include <string>

#include "server/jobs/job_store.hpp"
#include "server/state/state_folder.hpp"

namespace dccast::state {

/// What is wrong with the files of the store, seen from outside: missing or empty beside job
/// folders, or a write-ahead log that SQLite would drop without a word. Changes nothing. @return
/// empty for none
std::string store_file_fault(const StateFolder& folder);

/// Jobs that were acknowledged (jobs::was_accepted) and are not among `known_ids`.
/// @throws std::system_error
std::set<std::string> lost_jobs(const StateFolder& folder, const std::set<std::string>& known_ids);

/// Studies that have a file and no row: they were acknowledged, and rows are lost. The store must
/// be one of this version.
std::set<std::string> lost_studies(const StateFolder& folder);

/// Copies a write-ahead log with a damaged record to `jobs.sqlite-wal.damaged` and says so in the
/// log: SQLite will drop what comes after it and remove the file. @throws std::system_error
void keep_damaged_wal(const StateFolder& folder);

/// Opens the store of a daemon. One that is missing, damaged, or contradicts the folders of the jobs
/// is built again from them; its files are kept in quarantine, and the log says why. A write-ahead
/// log with a damaged record is kept first.
/// @throws jobs::StoreError  it cannot be read or written
std::unique_ptr<jobs::JobStore> open_store(const StateFolder& folder);

}  // namespace dccast::state
