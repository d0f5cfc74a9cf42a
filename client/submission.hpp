#pragma once

#include "client/connection.hpp"

namespace dccast::client {

/// Submits a job and repeats the call if the server is temporarily unavailable; the request id,
/// which must be set, makes this safe. Throws Interrupted. @return the status of the last attempt;
/// sets the job if it is OK
grpc::Status submit_patiently(Connection& connection, const v1::SubmitJobRequest& request,
                              v1::Job& job);

}  // namespace dccast::client
