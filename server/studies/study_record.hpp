#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "dccast/v1/study.pb.h"

namespace dccast::studies {

/// A study as it is kept. Its state is not kept: it follows from its runs.
struct StudyRecord {
  std::string id;  ///< UUID; the request_id where that is one
  std::string owner;
  std::int64_t created_ms = 0;  ///< since 1970
  std::int64_t changed_ms = 0;  ///< when a run last ended without a job, since 1970
  std::string case_sha256;      ///< of case and attachments as they came
  v1::CreateStudyRequest request;
};

/// One run of a study: the job that stands for it, or why it has none.
struct RunRecord {
  int number = 0;   ///< from 0, in the order of the plan
  int attempt = 0;  ///< jobs that were made for it so far
  std::string job;  ///< the last of them; empty while it waits to be queued
  v1::JobState outcome = v1::JOB_STATE_UNSPECIFIED;  ///< FAILED, CANCELLED: it gets no job
  v1::Failure failure;                               ///< why it was refused

  bool to_queue() const { return job.empty() && outcome == v1::JOB_STATE_UNSPECIFIED; }
};

/// The request id of the job of a run; it follows from the study alone, so that submitting a run
/// twice gives one job.
/// @param key      of the run in its plan
/// @param attempt  from 1
inline std::string job_request_id(const std::string& study, const std::string& key, int attempt) {
  const std::string first = study + "/" + key;
  return attempt == 1 ? first : first + "/" + std::to_string(attempt);
}

}  // namespace dccast::studies
