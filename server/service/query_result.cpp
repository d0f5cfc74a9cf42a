#include "server/jobs/events.hpp"
#include "server/service/handlers.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

namespace {

bool has_result(const v1::Job& job) {
  for (const v1::Artifact& artifact : job.artifacts())
    if (artifact.name() == "results.h5") return true;
  return false;
}

}  // namespace

grpc::Status query_result(Context& context, const v1::QueryResultRequest& request,
                          v1::QueryResultResponse& response) {
  if (const auto status = check_id(request.id()); !status.ok()) return status;
  const auto job = context.scheduler.find(request.id());
  if (!job) return job_not_found(request.id());
  for (v1::StepReport& step : jobs::step_history(*context.scheduler.log(request.id())))
    *response.add_steps() = std::move(step);
  if (const auto complete = context.store.complete_case(request.id()))
    response.mutable_case_()->ParseFromString(*complete);
  if (!request.frame()) return grpc::Status::OK;
  if (!has_result(*job))
    return wrong_state(*job, "it has no frame yet: watch it until it has succeeded");
  *response.mutable_frame() = context.intake.last_frame(context.jobs_directory / request.id());
  return grpc::Status::OK;
}

}  // namespace dccast::service
