#include "client/submission.hpp"

#include <thread>

namespace dccast::client {

grpc::Status submit_patiently(Connection& connection, const v1::SubmitJobRequest& request,
                              v1::Job& job) {
  constexpr int attempts = 3;
  for (int attempt = 1;; ++attempt) {
    const grpc::Status status = connection.try_call(&Stub::SubmitJob, request, job);
    if (status.error_code() != grpc::StatusCode::UNAVAILABLE || attempt == attempts) return status;
    std::this_thread::sleep_for(std::chrono::milliseconds(300 * attempt));
  }
}

}  // namespace dccast::client
