#include "server/service/answer_key.hpp"
#include "server/service/handlers.hpp"
#include "server/service/labels.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

grpc::Status examine_submission(Context& context, const Call& call,
                                const v1::SubmitJobRequest& request, ExaminedCase& examined) {
  if (const auto status = check_study(request.study()); !status.ok()) return status;
  if (const auto status = check_text("request_id", request.request_id()); !status.ok())
    return status;
  if (const auto status = check_labels(request.labels()); !status.ok()) return status;
  if (const auto status = check_changes(request.changes()); !status.ok()) return status;
  examined = context.intake.examine(request.case_(), request.attachments(), {},
                                    patience(call, context.check_timeout));
  return examined.verdict.faults_size() > 0 ? faulty_case(examined.verdict) : grpc::Status::OK;
}

grpc::Status submit_job(Context& context, const Call& call, const v1::SubmitJobRequest& request,
                        const ExaminedCase& examined, v1::Job& response) {
  response =
      context.scheduler.submit({.request_id = request.request_id(),
                                .study = request.study(),
                                .title = request.case_().title(),
                                .priority = request.priority(),
                                .owner = call.caller,
                                .case_sha256 = fingerprint(request.case_(), request.attachments()),
                                .submitted_case = request.case_().SerializeAsString(),
                                .complete_case = examined.complete.SerializeAsString(),
                                .labels = {request.labels().begin(), request.labels().end()},
                                .changes = {request.changes().begin(), request.changes().end()},
                                .answer_key = answer_key(examined.complete, request.attachments())},
                               request.attachments());
  return grpc::Status::OK;
}

}  // namespace dccast::service
