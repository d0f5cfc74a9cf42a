#include "server/service/study_handlers.hpp"
#include "server/service/study_status.hpp"

namespace dccast::service {

grpc::Status resume_study(StudyContext& context, const Call&, const v1::ResumeStudyRequest& request,
                          v1::Study& response) {
  if (const auto status = check_study_id(request.id()); !status.ok()) return status;
  return answer(context.studies.resume(request.id(), request.failed()), request.id(), "",
                &response);
}

}  // namespace dccast::service
