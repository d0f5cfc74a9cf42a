#include "client/submission.hpp"

namespace dccast::client {

grpc::Status submit_patiently(Connection& connection, const v1::SubmitJobRequest& request,
                              v1::Job& job) {
  try {
    return connection.try_call(&Stub::SubmitJob, request, job);
  } catch (const Interrupted&) {
    throw Interrupted(
        "the job may be in the queue already (dccast list). Submitting the case with "
        "--request-id " +
        request.request_id() + " gives one job in any case");
  }
}

}  // namespace dccast::client
