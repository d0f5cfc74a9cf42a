#pragma once

#include <google/protobuf/repeated_ptr_field.h>
#include <grpcpp/support/status.h>

#include <string>

#include "dccast/v1/job.pb.h"

namespace dccast::service {

/// OK, or INVALID_ARGUMENT: too many labels, an empty or too long one, or one with a control
/// character.
grpc::Status check_labels(const google::protobuf::RepeatedPtrField<std::string>& labels);

/// OK, or INVALID_ARGUMENT: more text than is kept with a job.
grpc::Status check_changes(const google::protobuf::RepeatedPtrField<v1::CaseChange>& changes);

}  // namespace dccast::service
