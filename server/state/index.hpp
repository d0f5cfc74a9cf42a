#pragma once

#include <filesystem>
#include <memory>
#include <ostream>
#include <set>
#include <string>

#include "server/jobs/store/job_store.hpp"
#include "server/state/state_folder.hpp"

/// The store as the index of the folders of the jobs: its rows are made from them.
namespace dccast::state {

/// The job as it was submitted, by the description in its folder.
/// @throws std::runtime_error  it cannot be read; the text is the reason
jobs::JobRecord described_job(const std::filesystem::path& folder);

/// Whether a row is of this job, whatever has become of it.
bool agrees(const jobs::JobRecord& row, const jobs::JobRecord& described);

/// Makes the row of a folder of `jobs/`, again where there is one.
/// @throws std::runtime_error  it cannot be made; the text is the reason
void index_job(jobs::JobStore& store, const std::filesystem::path& folder);

/// Makes the store from the folders of jobs and studies. The daemon holds the state folder.
/// @throws jobs::StoreError, std::system_error
void rebuild_index(const StateFolder& folder, std::ostream& out);

/// Jobs that were acknowledged (jobs::was_accepted) and are not among `known_ids`.
/// @throws std::system_error
std::set<std::string> lost_jobs(const StateFolder& folder, const std::set<std::string>& known_ids);

/// Studies that have a file and no row: they were acknowledged, and rows are lost. The store must
/// be one of this version.
std::set<std::string> lost_studies(const StateFolder& folder);

/// Opens the store of a daemon. One that is missing, damaged, of an earlier version, or lacks a job
/// is built again from the folders; its files are kept in quarantine, and the log has the reason.
/// Rows of jobs that have not ended are made to agree with their folders.
/// @throws jobs::StoreError  it cannot be read or written, or is of a later version
std::unique_ptr<jobs::JobStore> open_store(const StateFolder& folder);

}  // namespace dccast::state
