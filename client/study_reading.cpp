#include "client/study_reading.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "client/job_listing.hpp"

namespace dccast::client {
namespace {

v1::EvaluateStudyRequest question(const std::string& id, bool curves) {
  v1::EvaluateStudyRequest request;
  request.set_id(id);
  request.set_curves(curves);
  return request;
}

}  // namespace

std::vector<v1::Job> jobs_of_study(Connection& connection, const std::string& id) {
  v1::ListJobsRequest request;
  request.set_study(id);
  std::vector<v1::Job> jobs =
      list_jobs(connection, std::move(request), std::numeric_limits<int>::max());
  std::reverse(jobs.begin(), jobs.end());
  return jobs;
}

v1::StudyResult evaluate_study(Connection& connection, const std::string& id, bool curves) {
  return connection.call(&Stub::EvaluateStudy, question(id, curves));
}

Study read_study(Connection& connection, const std::string& id) {
  const v1::StudyResult result = evaluate_study(connection, id);
  if (!result.study().has_refinement())
    throw CommandFailed(ExitCode::invalid, "study " + id + " compares no meshes; dccast studies " +
                                               id + " shows what it is");
  return study_of(result, jobs_of_study(connection, id));
}

Study study_around(Connection& connection, const v1::Job& job) {
  if (job.study().empty()) return {};
  v1::StudyResult result;
  const grpc::Status status =
      connection.try_call(&Stub::EvaluateStudy, question(job.study(), false), result);
  // Jobs may have a study id in common that no study of the server has.
  if (status.error_code() == grpc::StatusCode::NOT_FOUND) return {};
  check(status, connection.server());
  if (!result.study().has_refinement()) return {};
  return study_of(result, jobs_of_study(connection, job.study()));
}

}  // namespace dccast::client
