#pragma once

#include <grpcpp/support/status.h>

#include "dccast/v1/service.pb.h"
#include "server/service/call.hpp"
#include "server/service/context.hpp"

/// The unary calls of SimulationService, one file each: translate, call, translate. Their status
/// codes stand in service.proto. They run on a thread that may wait, and may throw (see guarded()).

namespace dccast::service {

grpc::Status validate_case(Context& context, const Call& call,
                           const v1::ValidateCaseRequest& request,
                           v1::ValidateCaseResponse& response);
/// SubmitJob's first half: everything that can be wrong with the case. @param examined  on OK sound
grpc::Status examine_submission(Context& context, const Call& call,
                                const v1::SubmitJobRequest& request, ExaminedCase& examined);
/// Its second half: the job on the disk.
grpc::Status submit_job(Context& context, const Call& call, const v1::SubmitJobRequest& request,
                        const ExaminedCase& examined, v1::Job& response);
grpc::Status get_job(Context& context, const Call& call, const v1::GetJobRequest& request,
                     v1::Job& response);
grpc::Status list_jobs(Context& context, const Call& call, const v1::ListJobsRequest& request,
                       v1::ListJobsResponse& response);
grpc::Status cancel_job(Context& context, const Call& call, const v1::CancelJobRequest& request,
                        v1::Job& response);
grpc::Status pause_job(Context& context, const Call& call, const v1::PauseJobRequest& request,
                       v1::Job& response);
grpc::Status resume_job(Context& context, const Call& call, const v1::ResumeJobRequest& request,
                        v1::Job& response);
grpc::Status delete_job(Context& context, const Call& call, const v1::DeleteJobRequest& request,
                        v1::DeleteJobResponse& response);
grpc::Status query_result(Context& context, const Call& call, const v1::QueryResultRequest& request,
                          v1::QueryResultResponse& response);
grpc::Status list_alloys(Context& context, const Call& call, const v1::ListAlloysRequest& request,
                         v1::ListAlloysResponse& response);
grpc::Status get_server_info(Context& context, const Call& call,
                             const v1::GetServerInfoRequest& request,
                             v1::GetServerInfoResponse& response);

}  // namespace dccast::service
