#pragma once

#include <filesystem>

#include "server/jobs/folder/events.hpp"

namespace dccast::jobs {

/// A job as it was submitted, with its present marks. @throws as read_job()
JobRecord described_job(const std::filesystem::path& folder);

/// The record of a job, from its folder alone: description, marks, event log. The row of the job in
/// the store is this record at its last change.
/// @throws OtherFormat
/// @throws std::runtime_error  it cannot be read; the text is the reason
/// @throws std::system_error
JobRecord read_job(const std::filesystem::path& folder);

/// Whether a row says the same of a job as its folder.
bool agrees(const JobRecord& row, const JobRecord& stored);

/// Sequence of the last state in the event log of a folder; 0: none can be read.
/// @throws std::system_error
std::int64_t last_state_sequence(const std::filesystem::path& folder);

}  // namespace dccast::jobs
