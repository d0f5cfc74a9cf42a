#pragma once

#include "server/state/state_folder.hpp"

namespace dccast::state {

/// Converts the event logs of jobs and the files of studies that an earlier version of dccastd has
/// written (stored_v0.proto). What is of this version already is left alone. The daemon has locked
/// the state folder.
/// @throws std::system_error  a file cannot be read or written
void convert_stored_v0(const StateFolder& folder);

/// The same of the folder of one job. A worker of an earlier version that still runs there writes
/// on into the file that was replaced: no daemon of this version adopts it.
void convert_job_v0(const std::filesystem::path& job_folder);

}  // namespace dccast::state
