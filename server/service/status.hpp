#pragma once

#include <grpcpp/support/status.h>

#include <functional>
#include <string>

#include "dccast/v1/service.pb.h"
#include "server/jobs/scheduler.hpp"
#include "server/studies/studies.hpp"

namespace dccast::service {

/// Runs a handler; what it throws becomes a status with a remedy. Nothing gets past it.
grpc::Status guarded(const std::function<grpc::Status()>& handler);

/// RESOURCE_EXHAUSTED: the lane of this call is full.
grpc::Status too_many_waiting();

grpc::Status job_not_found(const std::string& id);
grpc::Status study_not_found(const std::string& id);

/// FAILED_PRECONDITION: the job's state does not permit it. @param remedy  what to do with a job
/// that has not ended; one that has can only be submitted again
grpc::Status wrong_state(const v1::Job& job, const std::string& remedy);

/// INVALID_ARGUMENT with the verdict, serialised, in the details. Details travel in the trailers of
/// the call, which clients limit to 8 KiB: faults that do not fit are left out there, and the
/// message states that.
grpc::Status faulty_case(const v1::ValidateCaseResponse& verdict);

/// Puts a reply into the answer: OK, NOT_FOUND, or FAILED_PRECONDITION with this remedy.
/// @param job, study  may be null
grpc::Status status_of(const jobs::Reply& reply, const std::string& id, const std::string& remedy,
                       v1::Job* job);
grpc::Status status_of(const studies::StudyReply& reply, const std::string& id,
                       const std::string& remedy, v1::Study* study);

}  // namespace dccast::service
