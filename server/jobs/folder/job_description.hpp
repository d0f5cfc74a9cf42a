#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// Description of a job in its folder, from which its row in the store can be rebuilt. Written
/// once, before the submission is acknowledged.
struct JobDescription {
  v1::Job job;                 ///< as submitted: identity, priority, owner, time, case_sha256
  std::string submitted_case;  ///< serialised
  std::string complete_case;   ///< serialised, with defaults and alloy card
  std::string answer_key{};    ///< see JobRecord; empty: none
  std::map<std::string, std::string> attachment_sha256{};  ///< by file name
  /// Further files without which the job is not what was submitted, as paths in its folder.
  std::vector<std::string> files{};
};

/// Name of the file. Its format: the header "DCCASTJD" (format.hpp), then two copies of six
/// frames. The frames are the serialised Job, the submitted Case, the complete Case, the answer
/// key, the digests of the attachments in the format of sha256sum(1), and the names of further
/// files, one a line; each begins with a byte of value 1. A description without the last frame
/// names no further files. The second copy is read if the first is damaged.
inline constexpr const char* description_file = "description.bin";
inline constexpr const char* description_kind = "DCCASTJD";  ///< see file_header()

/// Writes the file and syncs its content to disk. Its directory entry is durable only after
/// sync_directory().
/// @throws std::system_error
void write_job_description(const std::filesystem::path& folder, const JobDescription& description);

/// @throws OtherFormat
/// @throws std::runtime_error  the file is missing or damaged; the text is the reason
JobDescription read_job_description(const std::filesystem::path& folder);

/// Requires every file that the description names.
/// @throws std::runtime_error  the text is the reason
void require_files(const std::filesystem::path& folder, const JobDescription& description);
/// The same before and during a run: nothing but a file may stand where a run has its own.
/// @throws std::runtime_error  the text is the reason
void require_files_to_run(const std::filesystem::path& folder, const JobDescription& description);

/// Reads the complete case, the one that runs. @return false if it cannot be read
bool read_complete_case(const std::filesystem::path& folder, v1::Case& to);

}  // namespace dccast::jobs
