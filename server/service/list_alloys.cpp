#include "server/service/handlers.hpp"

namespace dccast::service {

grpc::Status list_alloys(Context& context, const Call&, const v1::ListAlloysRequest&,
                         v1::ListAlloysResponse& response) {
  for (const v1::Alloy& alloy : context.intake.alloys()) *response.add_alloys() = alloy;
  return grpc::Status::OK;
}

}  // namespace dccast::service
