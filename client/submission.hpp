#pragma once

#include "client/connection.hpp"

namespace dccast::client {

/// Submits, and asks again when the server was away for a moment: the request id, which must be set,
/// makes that safe. Throws Interrupted. @return the status of the last try; the job where it is OK
grpc::Status submit_patiently(Connection& connection, const v1::SubmitJobRequest& request,
                              v1::Job& job);

}  // namespace dccast::client
