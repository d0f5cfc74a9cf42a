#include "server/service/handlers.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

grpc::Status delete_job(Context& context, const Call&, const v1::DeleteJobRequest& request,
                        v1::DeleteJobResponse&) {
  if (const auto status = check_id(request.id()); !status.ok()) return status;
  return answer(context.scheduler.remove(request.id()), request.id(), "cancel it first", nullptr);
}

}  // namespace dccast::service
