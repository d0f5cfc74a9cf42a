#include "server/service/handlers.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

grpc::Status cancel_job(Context& context, const Call&, const v1::CancelJobRequest& request,
                        v1::Job& response) {
  if (const auto status = check_id(request.id()); !status.ok()) return status;
  if (const auto status = check_text("reason", request.reason()); !status.ok()) return status;
  return answer(context.scheduler.cancel(request.id(), request.reason()), request.id(), "",
                &response);
}

}  // namespace dccast::service
