#pragma once

#include <chrono>
#include <filesystem>

#include "dccast/v1/worker.pb.h"

namespace dccast::worker {

/// Commit of the sources of this program, with "-dirty" where they differ from it; "unknown" if it
/// was built without git.
extern const char commit[];

/// Writes what a run had of its machine beside its results (`run.json`): job, program and commit,
/// SHA-256 of the case, processor and system, begin, end and processor time. Results have none of
/// it that differs between two runs of one program, so that their bytes are equal. A file that
/// cannot be written is reported in the log of the worker; the run does not depend on it.
/// @param folder  of the job
/// @param begin   of this attempt
void write_run_facts(const v1::SolveCase& order, const std::filesystem::path& folder,
                     std::chrono::system_clock::time_point begin);

}  // namespace dccast::worker
