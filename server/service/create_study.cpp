#include <algorithm>

#include "server/service/labels.hpp"
#include "server/service/status.hpp"
#include "server/service/study_handlers.hpp"

namespace dccast::service {

namespace {

// Of a long sweep so many runs are checked before it is taken; one that is refused later fails.
constexpr int most_checked = 24;

grpc::Status check_texts(const v1::CreateStudyRequest& request) {
  if (const auto status = check_text("request_id", request.request_id()); !status.ok())
    return status;
  if (const auto status = check_labels(request.labels()); !status.ok()) return status;
  return check_changes(request.changes());
}

grpc::Status check_plan(const v1::CreateStudyRequest& request) {
  v1::ValidateCaseResponse verdict;
  for (v1::Fault& fault : studies::plan_faults(request)) *verdict.add_faults() = std::move(fault);
  return verdict.faults_size() > 0 ? faulty_case(verdict) : grpc::Status::OK;
}

/// The verdict with the name of the run in front.
grpc::Status faulty_run(const std::string& name, const v1::ValidateCaseResponse& verdict) {
  const grpc::Status status = faulty_case(verdict);
  return {status.error_code(), name + ": " + status.error_message(), status.error_details()};
}

grpc::Status check_run(StudyContext& context, const Call& call,
                       const v1::CreateStudyRequest& request, const studies::PlannedRun& run) {
  const auto examined = context.service.intake.examine(
      run.description, request.attachments(), {}, patience(call, context.service.check_timeout));
  if (examined.verdict.faults_size() == 0) return grpc::Status::OK;
  return faulty_run(run.name, examined.verdict);
}

}  // namespace

grpc::Status examine_study(StudyContext& context, const Call& call,
                           const v1::CreateStudyRequest& request) {
  if (const auto status = check_texts(request); !status.ok()) return status;
  if (const auto status = check_plan(request); !status.ok()) return status;
  const auto plan = studies::study_plan(request);
  const int checked = std::min(plan->runs(), most_checked);
  for (int i = 0; i < checked; ++i) {
    // From the first run to the last.
    const int number = checked == 1 ? 0 : i * (plan->runs() - 1) / (checked - 1);
    if (const auto status = check_run(context, call, request, plan->run(number)); !status.ok())
      return status;
  }
  return grpc::Status::OK;
}

grpc::Status create_study(StudyContext& context, const Call& call,
                          const v1::CreateStudyRequest& request, v1::Study& response) {
  response = context.studies.create(request, call.caller);
  return grpc::Status::OK;
}

}  // namespace dccast::service
