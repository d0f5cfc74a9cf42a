#include "client/study_reading.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "client/divided_case.hpp"
#include "client/job_listing.hpp"

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
  std::vector<v1::Job> strangers;
  std::optional<v1::Case> first;
  for (const v1::Job& job : jobs_of_study(connection, id)) {
    v1::QueryResultRequest request;
    request.set_id(job.id());
    v1::QueryResultResponse result;
    const grpc::Status status = connection.try_call(&Stub::QueryResult, request, result);
    if (status.error_code() == grpc::StatusCode::NOT_FOUND)
      continue;  // deleted since it was listed
    check(status, connection.server());
    if (!first) first = like != nullptr ? *like : result.case_();
    if (!same_but_divided(*first, result.case_())) {
      strangers.push_back(job);
      continue;
    }
    StudyLevel& run = runs.emplace_back();
    run.refinement = result.case_().mesh().refinement();
    run.job = job;
    for (const v1::StepReport& step : result.steps()) run.history.add(step);
  }
  Study study = study_of(id, std::move(runs));
  study.others.insert(study.others.end(), strangers.begin(), strangers.end());
  return study;
}

Study study_around(Connection& connection, const v1::Job& job, const v1::Case& casting) {
  return job.study().empty() ? Study{} : read_study(connection, job.study(), &casting);
}

}  // namespace dccast::client
