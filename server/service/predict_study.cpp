#include "server/service/study_handlers.hpp"
#include "server/service/study_status.hpp"

namespace dccast::service {

grpc::Status predict_study(StudyContext& context, const Call&,
                           const v1::PredictStudyRequest& request, v1::Prediction& response) {
  if (const auto status = check_study_id(request.id()); !status.ok()) return status;
  try {
    auto prediction = context.studies.predict(request);
    if (!prediction) return study_not_found(request.id());
    response = std::move(*prediction);
    return grpc::Status::OK;
  } catch (const studies::OutsideDomain& outside) {
    return {grpc::StatusCode::OUT_OF_RANGE, outside.what()};
  } catch (const studies::FaultyPlace& fault) {
    return {grpc::StatusCode::INVALID_ARGUMENT, fault.what()};
  } catch (const studies::CannotPredict& reason) {
    return {grpc::StatusCode::FAILED_PRECONDITION, reason.what()};
  }
}

}  // namespace dccast::service
