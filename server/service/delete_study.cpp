#include "server/service/study_handlers.hpp"
#include "server/service/study_status.hpp"

namespace dccast::service {

grpc::Status delete_study(StudyContext& context, const Call&, const v1::DeleteStudyRequest& request,
                          v1::DeleteStudyResponse&) {
  if (const auto status = check_study_id(request.id()); !status.ok()) return status;
  return answer(context.studies.remove(request.id()), request.id(),
                "cancel it first, and wait until its jobs have ended", nullptr);
}

}  // namespace dccast::service
