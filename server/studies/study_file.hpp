#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"
#include "server/jobs/folder/job_folder.hpp"

namespace dccast::studies {

/// Stored part of a study. Its state is not stored: it follows from the runs.
struct StudyRecord {
  std::string id;  ///< UUID; the request_id where that is one
  std::string owner;
  std::int64_t created_ms = 0;  ///< since 1970
  std::int64_t changed_ms = 0;  ///< last end of a run without a job, since 1970
  std::string case_sha256;      ///< of the submitted case and attachments
  v1::CreateStudyRequest request;
};

/// One run of a study, with its job or the reason why it has none.
struct RunRecord {
  int number = 0;     ///< from 0, in the order of the plan
  int attempt = 0;    ///< number of jobs made for it so far
  std::string job{};  ///< the last job; empty while the run waits to be queued
  v1::JobState outcome = v1::JOB_STATE_UNSPECIFIED;  ///< FAILED or CANCELLED: it receives no job
  v1::Finding failure;                               ///< reason of a refusal

  /// Whether the run has no job yet and has not been refused.
  bool to_queue() const { return job.empty() && outcome == v1::JOB_STATE_UNSPECIFIED; }
};

/// Request id of a run's job. It depends on the study and the run only, so that submitting a run
/// twice gives one job.
/// @param key      of the run in its plan
/// @param attempt  from 1
inline std::string job_request_id(const std::string& study, const std::string& key, int attempt) {
  const std::string first = study + "/" + key;
  return attempt == 1 ? first : first + "/" + std::to_string(attempt);
}

/// Path of a study's file, `studies/<id>.bin`. The file is the truth; rows of the store are an
/// index that can be rebuilt from it and the jobs. It is written before the study is acknowledged
/// and removed before its row: a file without a row shows that rows were lost.
///
/// Format: the header "DCCASTSD" (jobs/folder/format.hpp), then three frames: a serialised Study
/// with id, owner and create_time, the serialised CreateStudyRequest, case_sha256 in hexadecimal. A
/// further frame records each cancellation, refusal or requeueing of a run without a job: its
/// number, attempt and outcome, 4 bytes each, and the failure, a serialised Finding.
inline constexpr const char* study_file_kind = "DCCASTSD";
std::filesystem::path study_file(const std::filesystem::path& directory, const std::string& id);

/// Folder of the files named by a study's case: `studies/<id>.attachments`. Written before study
/// and row, removed after them.
std::filesystem::path attachments_of_study(const std::filesystem::path& directory,
                                           const std::string& id);

/// The files named by a study's request, in the study's folder.
jobs::Attachments study_attachments(const std::filesystem::path& directory,
                                    const StudyRecord& record);

/// Copies the files of a study into its folder. They survive a crash of the machine once this has
/// returned. @throws std::system_error
void write_study_attachments(const std::filesystem::path& directory, const std::string& id,
                             const jobs::Attachments& attachments);

/// Removes the files of studies whose creation was interrupted.
/// @param known  ids of the studies that have a row @throws std::filesystem::filesystem_error
void remove_orphaned_attachments(const std::filesystem::path& directory,
                                 const std::vector<std::string>& known);

/// Writes the file, or replaces its first three frames; it survives a crash of the machine once
/// this has returned. @throws std::system_error
void write_study_file(const std::filesystem::path& directory, const StudyRecord& record);

/// Appends the state of runs without a job; it survives a crash of the machine once this has
/// returned. @throws std::system_error
void append_runs(const std::filesystem::path& directory, const std::string& id,
                 const std::vector<RunRecord>& runs);

/// Last appended state of each run, by its number. @throws as read_study_file()
std::map<int, RunRecord> read_study_runs(const std::filesystem::path& directory,
                                         const std::string& id);

/// @throws jobs::OtherFormat
/// @throws std::runtime_error  it is missing or damaged
StudyRecord read_study_file(const std::filesystem::path& directory, const std::string& id);

/// @throws std::system_error
void remove_study_file(const std::filesystem::path& directory, const std::string& id);

/// Ids of the studies that have a file. @throws std::filesystem::filesystem_error
std::set<std::string> ids_of_study_files(const std::filesystem::path& directory);

}  // namespace dccast::studies
