#include "server/service/handlers.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

grpc::Status submit_job(Context& context, const v1::SubmitJobRequest& request, v1::Job& response) {
  if (const auto status = check_study(request.study()); !status.ok()) return status;
  const ExaminedCase examined = context.intake.examine(request.case_(), request.attachments());
  if (examined.verdict.faults_size() > 0) return faulty_case(examined.verdict);
  response =
      context.scheduler.submit({.request_id = request.request_id(),
                                .study = request.study(),
                                .title = request.case_().title(),
                                .priority = request.priority(),
                                .case_sha256 = fingerprint(request.case_(), request.attachments()),
                                .submitted_case = request.case_().SerializeAsString(),
                                .complete_case = examined.complete.SerializeAsString()},
                               request.attachments());
  return grpc::Status::OK;
}

}  // namespace dccast::service
