#pragma once

#include <filesystem>
#include <memory>
#include <ostream>
#include <set>
#include <string>

#include "server/jobs/store/job_store.hpp"
#include "server/state/state_folder.hpp"

/// The store as an index of the job folders, from which its rows are rebuilt.
namespace dccast::state {

/// The job as it was submitted, from the description in its folder.
/// @throws std::runtime_error  it cannot be read; the text is the reason
jobs::JobRecord described_job(const std::filesystem::path& folder);

/// Whether a row belongs to this job, whatever its present state.
bool agrees(const jobs::JobRecord& row, const jobs::JobRecord& described);

/// Creates or replaces the row of a job from its folder in `jobs/`.
/// @throws std::runtime_error  the row cannot be made; the text is the reason
void index_job(jobs::JobStore& store, const std::filesystem::path& folder);

/// Rebuilds the store from the folders of jobs and studies. The daemon has locked the state folder.
/// @throws jobs::StoreError, std::system_error
void rebuild_index(const StateFolder& folder, std::ostream& out);

/// Jobs that were acknowledged (jobs::was_accepted) and are not among `known_ids`.
/// @throws std::system_error
std::set<std::string> lost_jobs(const StateFolder& folder, const std::set<std::string>& known_ids);

/// Studies that have a file and no row: they were acknowledged, and rows are lost. The store must
/// be one of this version.
std::set<std::string> lost_studies(const StateFolder& folder);

/// Opens the store of a daemon. A store that is missing, damaged, of another version, or lacks a
/// job is rebuilt from the folders; its files go to quarantine and the reason is logged. Rows of
/// jobs that have not ended are made to agree with their folders.
/// @throws jobs::StoreError  it cannot be read or written
/// @throws jobs::OtherFormat
std::unique_ptr<jobs::JobStore> open_store(const StateFolder& folder);

}  // namespace dccast::state
