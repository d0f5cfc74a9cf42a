#include "server/service/handlers.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

grpc::Status pause_job(Context& context, const Call&, const v1::PauseJobRequest& request,
                       v1::Job& response) {
  if (const auto status = check_id(request.id()); !status.ok()) return status;
  return answer(context.scheduler.pause(request.id()), request.id(), "", &response);
}

}  // namespace dccast::service
