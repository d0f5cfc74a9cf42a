#include "server/service/handlers.hpp"

namespace dccast::service {

grpc::Status validate_case(Context& context, const Call& call,
                           const v1::ValidateCaseRequest& request,
                           v1::ValidateCaseResponse& response) {
  auto examined =
      context.intake.examine(request.case_(), request.attachments(),
                             {request.faulty_keys().begin(), request.faulty_keys().end()},
                             patience(call, context.check_timeout), jobs::Question::judge);
  response = std::move(examined.verdict);
  if (response.faults_size() == 0) *response.mutable_complete() = std::move(examined.complete);
  return grpc::Status::OK;
}

}  // namespace dccast::service
