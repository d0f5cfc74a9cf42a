#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// What a job's folder says about the job, so that its row in the store can be made again. Written
/// once, before the job is acknowledged.
struct JobDescription {
  v1::Job job;  ///< as it was submitted: identity, priority, owner, time, case_sha256
  std::string submitted_case;  ///< serialised
  std::string complete_case;   ///< serialised, with defaults and alloy card
  std::string answer_key{};    ///< see JobRecord; empty: none, or of an earlier version
  std::map<std::string, std::string> attachment_sha256{};  ///< by name; of an earlier version none
};

/// Name of the file: 8 bytes "DCCASTJD", version 2 and zero as in EVENT_LOG.md, then twice the same
/// frames: the serialised Job, the submitted Case, the complete Case, the answer key, the digests
/// of the attachments as sha256sum(1) writes them, each behind one byte that is 1. Where the first
/// five are damaged the second five are read. Version 1 has three or four frames, once.
inline constexpr const char* description_file = "description.bin";

/// Writes the file so that its content survives a crash; its name does after sync_directory().
/// @throws std::system_error
void write_job_description(const std::filesystem::path& folder, const JobDescription& description);

/// @throws std::runtime_error  there is none, or it is damaged; the text says which
JobDescription read_job_description(const std::filesystem::path& folder);

/// The case that runs. @return false where it cannot be read
bool read_complete_case(const std::filesystem::path& folder, v1::Case& to);

}  // namespace dccast::jobs
