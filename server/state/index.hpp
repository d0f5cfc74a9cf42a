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

/// Creates or replaces the row of a job from its folder in `jobs/`.
/// @throws std::runtime_error  the row cannot be made; the text is the reason
void index_job(jobs::JobStore& store, const std::filesystem::path& folder);

/// Reads every row of jobs and studies, so that a damaged one is found. @throws jobs::StoreError
void read_all_rows(const StateFolder& folder, jobs::JobStore& store);

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
/// study is rebuilt from the folders; its files go to quarantine and the reason is logged. Rows
/// that are missing, or older than their folders, are made again.
/// @throws jobs::StoreError  it cannot be read or written
/// @throws jobs::OtherFormat
std::unique_ptr<jobs::JobStore> open_store(const StateFolder& folder);

}  // namespace dccast::state
