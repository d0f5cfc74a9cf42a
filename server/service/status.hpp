#pragma once

#include <grpcpp/support/status.h>

#include <functional>
#include <string>

#include "dccast/v1/service.pb.h"
#include "server/jobs/scheduler.hpp"

namespace dccast::service {

/// Runs a handler; what it throws becomes a status with a remedy. Nothing gets past it.
grpc::Status guarded(const std::function<grpc::Status()>& handler);

/// OK, or INVALID_ARGUMENT when this is no job id at all.
grpc::Status check_id(const std::string& id);

/// OK, or INVALID_ARGUMENT when this is neither a study id nor empty.
grpc::Status check_study(const std::string& study);

/// INVALID_ARGUMENT for a free text of a request that is too long, or is not one line that can be
/// shown.
grpc::Status check_text(const std::string& name, const std::string& text);

/// RESOURCE_EXHAUSTED: the lane of this call is full.
grpc::Status too_many_waiting();

grpc::Status job_not_found(const std::string& id);

/// FAILED_PRECONDITION: the job's state does not permit it. @param remedy  what to do with a job
/// that has not ended; one that has can only be submitted again
grpc::Status wrong_state(const v1::Job& job, const std::string& remedy);

/// INVALID_ARGUMENT with the verdict, serialised, in the details. Details travel in the trailers of
/// the call, which clients limit to 8 KiB: faults that do not fit are left out there, and the
/// message says so.
grpc::Status faulty_case(const v1::ValidateCaseResponse& verdict);

/// Puts a Reply into the answer: OK, NOT_FOUND, or wrong_state() with this remedy.
grpc::Status answer(const jobs::Reply& reply, const std::string& id, const std::string& remedy,
                    v1::Job* job);

}  // namespace dccast::service
