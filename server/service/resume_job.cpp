#include "server/service/handlers.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

grpc::Status resume_job(Context& context, const Call&, const v1::ResumeJobRequest& request,
                        v1::Job& response) {
  if (const auto status = check_id(request.id()); !status.ok()) return status;
  return answer(context.scheduler.resume(request.id()), request.id(),
                "it is not paused and goes on by itself", &response);
}

}  // namespace dccast::service
