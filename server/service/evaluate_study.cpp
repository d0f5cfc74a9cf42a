#include "server/service/study_handlers.hpp"
#include "server/service/study_status.hpp"

namespace dccast::service {

grpc::Status evaluate_study(StudyContext& context, const Call&,
                            const v1::EvaluateStudyRequest& request, v1::StudyResult& response) {
  if (const auto status = check_study_id(request.id()); !status.ok()) return status;
  auto result = context.studies.evaluate(request);
  if (!result) return study_not_found(request.id());
  response = std::move(*result);
  return grpc::Status::OK;
}

}  // namespace dccast::service
