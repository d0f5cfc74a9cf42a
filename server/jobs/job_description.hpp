#pragma once

#include <filesystem>
#include <string>

#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// What a job's folder says about the job, so that its row in the store can be made again. Written
/// once, before the job is acknowledged.
struct JobDescription {
  v1::Job job;  ///< as it was submitted: identity, priority, owner, time, case_sha256
  std::string submitted_case;  ///< serialised
  std::string complete_case;   ///< serialised, with defaults and alloy card
  std::string answer_key{};    ///< see JobRecord; empty: none, or of an earlier version
};

/// Name of the file: 8 bytes "DCCASTJD", version 1 and zero as in EVENT_LOG.md, then three frames:
/// the serialised Job, the submitted Case, the complete Case, each behind one byte that is 1.
inline constexpr const char* description_file = "description.bin";

/// Writes the file so that its content survives a crash; its name does after sync_directory().
/// @throws std::system_error
void write_job_description(const std::filesystem::path& folder, const JobDescription& description);

/// @throws std::runtime_error  there is none, or it is damaged; the text says which
JobDescription read_job_description(const std::filesystem::path& folder);

}  // namespace dccast::jobs
