#pragma once

#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/job_store.hpp"

namespace dccast::jobs {

/// A case that was found good, ready to become a job.
struct NewJob {
  std::string request_id;  ///< empty: none
  std::string study{};     ///< empty: none
  std::string title;
  v1::Priority priority = v1::NORMAL;
  std::string owner{};         ///< who submits it
  std::string case_sha256;     ///< of the case as it was submitted, with its attachments
  std::string submitted_case;  ///< serialised
  std::string complete_case;   ///< serialised, with defaults and alloy card
  std::vector<std::string> labels{};
  std::vector<v1::CaseChange> changes{};  ///< made in the case already
  std::string answer_key{};               ///< see JobRecord
};

/// The job as it is stored first: with an id of its own, queued, created now.
JobRecord record_of_new(const NewJob& new_job, const Attachments& attachments);

}  // namespace dccast::jobs
