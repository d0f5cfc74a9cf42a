#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "server/studies/studies.hpp"

namespace dccast::service {

/// OK, or INVALID_ARGUMENT when this is no study id at all.
grpc::Status check_study_id(const std::string& id);

grpc::Status study_not_found(const std::string& id);

/// Puts a reply into the answer: OK, NOT_FOUND, or FAILED_PRECONDITION with this remedy.
grpc::Status answer(const studies::StudyReply& reply, const std::string& id,
                    const std::string& remedy, v1::Study* study);

}  // namespace dccast::service
