#pragma once

#include <grpcpp/support/server_callback.h>
#include <grpcpp/support/status.h>

#include "dccast/v1/service.pb.h"
#include "server/service/call.hpp"
#include "server/service/context.hpp"
#include "server/service/stream_call.hpp"
#include "server/service/work_pool.hpp"
#include "server/studies/studies.hpp"

/// The calls of SimulationService about studies, one file each, as those of handlers.hpp.

namespace dccast::service {

/// What these handlers work with.
struct StudyContext {
  studies::Studies& studies;
  Context& service;
};

/// CreateStudy's first half: everything that can be wrong with the plan and its cases.
grpc::Status examine_study(StudyContext& context, const Call& call,
                           const v1::CreateStudyRequest& request);
/// Its second half: the study on the disk.
grpc::Status create_study(StudyContext& context, const Call& call,
                          const v1::CreateStudyRequest& request, v1::Study& response);
grpc::Status get_study(StudyContext& context, const Call& call, const v1::GetStudyRequest& request,
                       v1::Study& response);
grpc::Status list_studies(StudyContext& context, const Call& call,
                          const v1::ListStudiesRequest& request, v1::ListStudiesResponse& response);
grpc::Status cancel_study(StudyContext& context, const Call& call,
                          const v1::CancelStudyRequest& request, v1::Study& response);
grpc::Status resume_study(StudyContext& context, const Call& call,
                          const v1::ResumeStudyRequest& request, v1::Study& response);
grpc::Status delete_study(StudyContext& context, const Call& call,
                          const v1::DeleteStudyRequest& request, v1::DeleteStudyResponse& response);
grpc::Status evaluate_study(StudyContext& context, const Call& call,
                            const v1::EvaluateStudyRequest& request, v1::StudyResult& response);
grpc::Status predict_study(StudyContext& context, const Call& call,
                           const v1::PredictStudyRequest& request, v1::Prediction& response);
/// The stream deletes itself when its call is done; the study is looked up in `lane`.
grpc::ServerWriteReactor<v1::Study>* watch_study(StudyContext& context, WorkPool& lane,
                                                 StreamCall call,
                                                 const v1::WatchStudyRequest& request);

/// The file is made in `lane`, of the study as it is then.
grpc::ServerWriteReactor<v1::FetchResultResponse>* fetch_study(
    StudyContext& context, WorkPool& lane, const StreamCall& call,
    const v1::FetchStudyRequest& request);

}  // namespace dccast::service
