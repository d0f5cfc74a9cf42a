#include "client/submission.hpp"

namespace dccast::client {

grpc::Status submit_patiently(Connection& connection, const v1::SubmitJobRequest& request,
                              v1::Job& job) {
  constexpr int attempts = 3;
  try {
    for (int attempt = 1;; ++attempt) {
      const grpc::Status status = connection.try_call(&Stub::SubmitJob, request, job);
      if (status.error_code() != grpc::StatusCode::UNAVAILABLE || attempt == attempts)
        return status;
      connection.interruption().sleep(std::chrono::milliseconds(300 * attempt));
    }
  } catch (const Interrupted&) {
    throw Interrupted(
        "the job may be in the queue already (dccast list). Submitting the case with "
        "--request-id " +
        request.request_id() + " gives one job in any case");
  }
}

}  // namespace dccast::client
