#include "server/service/handlers.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

grpc::Status get_job(Context& context, const Call&, const v1::GetJobRequest& request,
                     v1::Job& response) {
  if (const auto status = check_id(request.id()); !status.ok()) return status;
  auto job = context.scheduler.find(request.id());
  if (!job) return job_not_found(request.id());
  response = std::move(*job);
  return grpc::Status::OK;
}

}  // namespace dccast::service
