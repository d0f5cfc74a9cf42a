#include "client/study_reading.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "client/divided_case.hpp"
#include "client/job_listing.hpp"
#include "client/job_result.hpp"

namespace dccast::client {

std::vector<v1::Job> jobs_of_study(Connection& connection, const std::string& id) {
  v1::ListJobsRequest request;
  request.set_study(id);
  std::vector<v1::Job> jobs =
      list_jobs(connection, std::move(request), std::numeric_limits<int>::max());
  std::reverse(jobs.begin(), jobs.end());
  return jobs;
}

Study read_study(Connection& connection, const std::string& id, const v1::Case* like) {
  std::vector<StudyLevel> runs;
  std::vector<v1::Job> foreign_jobs;
  std::optional<v1::Case> first;
  for (const v1::Job& job : jobs_of_study(connection, id)) {
    v1::QueryResultResponse result;
    const grpc::Status status = try_query_result(connection, job.id(), false, result);
    if (status.error_code() == grpc::StatusCode::NOT_FOUND)
      continue;  // deleted since it was listed
    check(status, connection.server());
    if (!first) first = like != nullptr ? *like : result.case_();
    if (!is_refined_case(*first, result.case_())) {
      foreign_jobs.push_back(job);
      continue;
    }
    StudyLevel& run = runs.emplace_back();
    run.refinement = result.case_().mesh().refinement();
    run.job = job;
    run.history = render::curl_history(job, result);
  }
  Study study = study_of(id, std::move(runs));
  study.others.insert(study.others.end(), foreign_jobs.begin(), foreign_jobs.end());
  return study;
}

Study study_around(Connection& connection, const v1::Job& job, const v1::Case& casting) {
  return job.study().empty() ? Study{} : read_study(connection, job.study(), &casting);
}

}  // namespace dccast::client
