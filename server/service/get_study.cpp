#include "server/service/study_handlers.hpp"
#include "server/service/study_status.hpp"

namespace dccast::service {

grpc::Status get_study(StudyContext& context, const Call&, const v1::GetStudyRequest& request,
                       v1::Study& response) {
  if (const auto status = check_study_id(request.id()); !status.ok()) return status;
  auto study = context.studies.find(request.id());
  if (!study) return study_not_found(request.id());
  response = std::move(*study);
  return grpc::Status::OK;
}

}  // namespace dccast::service
