#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "dccast/v1/service.grpc.pb.h"
#include "server/service/call.hpp"
#include "server/service/context.hpp"
#include "server/service/lanes.hpp"
#include "server/service/study_handlers.hpp"

namespace dccast::service {

/// Hands every call of SimulationService to its handler. Callback API: no thread waits for a
/// stream.
class SimulationService final : public v1::SimulationService::CallbackService {
public:
  /// @param address  where it listens
  SimulationService(Context& context, studies::Studies& studies, const std::string& address);

  using Unary = grpc::ServerUnaryReactor;
  using Wire = grpc::CallbackServerContext;
  Unary* ValidateCase(Wire*, const v1::ValidateCaseRequest*, v1::ValidateCaseResponse*) override;
  Unary* SubmitJob(Wire*, const v1::SubmitJobRequest*, v1::Job*) override;
  Unary* GetJob(Wire*, const v1::GetJobRequest*, v1::Job*) override;
  Unary* ListJobs(Wire*, const v1::ListJobsRequest*, v1::ListJobsResponse*) override;
  Unary* CancelJob(Wire*, const v1::CancelJobRequest*, v1::Job*) override;
  Unary* PauseJob(Wire*, const v1::PauseJobRequest*, v1::Job*) override;
  Unary* ResumeJob(Wire*, const v1::ResumeJobRequest*, v1::Job*) override;
  Unary* DeleteJob(Wire*, const v1::DeleteJobRequest*, v1::DeleteJobResponse*) override;
  Unary* QueryResult(Wire*, const v1::QueryResultRequest*, v1::QueryResultResponse*) override;
  Unary* CreateStudy(Wire*, const v1::CreateStudyRequest*, v1::Study*) override;
  Unary* GetStudy(Wire*, const v1::GetStudyRequest*, v1::Study*) override;
  Unary* ListStudies(Wire*, const v1::ListStudiesRequest*, v1::ListStudiesResponse*) override;
  Unary* CancelStudy(Wire*, const v1::CancelStudyRequest*, v1::Study*) override;
  Unary* ResumeStudy(Wire*, const v1::ResumeStudyRequest*, v1::Study*) override;
  Unary* DeleteStudy(Wire*, const v1::DeleteStudyRequest*, v1::DeleteStudyResponse*) override;
  Unary* EvaluateStudy(Wire*, const v1::EvaluateStudyRequest*, v1::StudyResult*) override;
  Unary* PredictStudy(Wire*, const v1::PredictStudyRequest*, v1::Prediction*) override;
  Unary* ListAlloys(Wire*, const v1::ListAlloysRequest*, v1::ListAlloysResponse*) override;
  Unary* GetServerInfo(Wire*, const v1::GetServerInfoRequest*, v1::GetServerInfoResponse*) override;
  grpc::ServerWriteReactor<v1::JobEvent>* WatchJob(Wire*, const v1::WatchJobRequest*) override;
  grpc::ServerWriteReactor<v1::FetchResultResponse>* FetchResult(
      Wire*, const v1::FetchResultRequest*) override;
  grpc::ServerWriteReactor<v1::QueryButtCurlResponse>* QueryButtCurl(
      Wire*, const v1::QueryButtCurlRequest*) override;
  grpc::ServerWriteReactor<v1::FetchResultResponse>* FetchStudy(
      Wire*, const v1::FetchStudyRequest*) override;
  grpc::ServerWriteReactor<v1::Study>* WatchStudy(Wire*, const v1::WatchStudyRequest*) override;

private:
  /// A call on its way to a lane.
  struct Pending {
    Wire* wire;
    Unary* reactor;
    std::size_t bytes;  ///< of its request
  };

  /// Does `work` in a lane, for a call that is still wanted then, and `then` when it is over
  /// without a fault; else answers why not.
  void in_lane(WorkPool& lane, const Pending& pending,
               std::function<grpc::Status(const Call&)> work, std::function<void()> then);
  /// Answers by a handler in a lane.
  template <class Of, class Request, class Response>
  Unary* answer(WorkPool& lane, Wire* wire, Of& context, const Request* request, Response* response,
                grpc::Status (*handler)(Of&, const Call&, const Request&, Response&));
  template <class Request, class Response>
  Unary* answer(WorkPool& lane, Wire* wire, const Request* request, Response* response,
                grpc::Status (*handler)(Context&, const Call&, const Request&, Response&)) {
    return answer(lane, wire, context_, request, response, handler);
  }

  Context& context_;
  StudyContext studies_;
  LocalUsers users_;
  Lanes lanes_;
};

}  // namespace dccast::service
