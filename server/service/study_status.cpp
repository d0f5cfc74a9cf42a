#include "server/service/study_status.hpp"

#include "server/service/status.hpp"

namespace dccast::service {

grpc::Status check_study_id(const std::string& id) {
  // An empty id stands for no study where a job may have one.
  return check_study(id.empty() ? " " : id);
}

grpc::Status study_not_found(const std::string& id) {
  return {grpc::StatusCode::NOT_FOUND,
          "there is no study " + id + " here; ListStudies names those there are"};
}

grpc::Status answer(const studies::StudyReply& reply, const std::string& id,
                    const std::string& remedy, v1::Study* study) {
  using Kind = studies::StudyReply::Kind;
  if (reply.kind == Kind::not_found) return study_not_found(id);
  if (reply.kind == Kind::wrong_state)
    return {grpc::StatusCode::FAILED_PRECONDITION,
            "study " + id + " is " + v1::StudyState_Name(reply.study.state()) + "; " + remedy};
  if (study != nullptr) *study = reply.study;
  return grpc::Status::OK;
}

}  // namespace dccast::service
