#include "server/service/status.hpp"
#include "server/service/study_handlers.hpp"
#include "server/service/study_status.hpp"

namespace dccast::service {

grpc::Status cancel_study(StudyContext& context, const Call&, const v1::CancelStudyRequest& request,
                          v1::Study& response) {
  if (const auto status = check_study_id(request.id()); !status.ok()) return status;
  if (const auto status = check_text("reason", request.reason()); !status.ok()) return status;
  return answer(context.studies.cancel(request.id(), request.reason()), request.id(), "",
                &response);
}

}  // namespace dccast::service
