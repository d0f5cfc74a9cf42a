#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "dccast/v1/service.grpc.pb.h"
#include "server/service/call.hpp"
#include "server/service/call_pools.hpp"
#include "server/service/context.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// The calls of SimulationService; their status codes stand in service.proto. A call checks its
/// request, asks jobs, studies or intake, and puts the outcome into the response. Callback API: no
/// thread waits for a stream, and what waits for the disk or computes does so in a pool.
class SimulationService final : public v1::SimulationService::CallbackService {
public:
  /// @param context  outlives the service
  explicit SimulationService(Context& context);

  /// Short names of gRPC's types for the declarations below.
  using Unary = grpc::ServerUnaryReactor;
  using Wire = grpc::CallbackServerContext;
  template <class Message>
  using Stream = grpc::ServerWriteReactor<Message>;

  // cases.cpp
  Unary* ReadCase(Wire*, const v1::ReadCaseRequest*, v1::ReadCaseResponse*) override;
  Unary* ValidateCase(Wire*, const v1::ValidateCaseRequest*, v1::ValidateCaseResponse*) override;
  Unary* ListAlloys(Wire*, const v1::ListAlloysRequest*, v1::ListAlloysResponse*) override;
  Unary* GetServerInfo(Wire*, const v1::GetServerInfoRequest*, v1::GetServerInfoResponse*) override;

  // tokens.cpp
  Unary* Enrol(Wire*, const v1::EnrolRequest*, v1::EnrolResponse*) override;
  Unary* WhoAmI(Wire*, const v1::WhoAmIRequest*, v1::WhoAmIResponse*) override;
  Unary* IssueSignIn(Wire*, const v1::IssueSignInRequest*, v1::IssueSignInResponse*) override;
  Unary* ListTokens(Wire*, const v1::ListTokensRequest*, v1::ListTokensResponse*) override;
  Unary* RevokeToken(Wire*, const v1::RevokeTokenRequest*, v1::RevokeTokenResponse*) override;

  // jobs.cpp
  Unary* SubmitJob(Wire*, const v1::SubmitJobRequest*, v1::Job*) override;
  Unary* GetJob(Wire*, const v1::GetJobRequest*, v1::Job*) override;
  Unary* ListJobs(Wire*, const v1::ListJobsRequest*, v1::ListJobsResponse*) override;
  Unary* CancelJob(Wire*, const v1::CancelJobRequest*, v1::Job*) override;
  Unary* PauseJob(Wire*, const v1::PauseJobRequest*, v1::Job*) override;
  Unary* ResumeJob(Wire*, const v1::ResumeJobRequest*, v1::Job*) override;
  Unary* UpdateJob(Wire*, const v1::UpdateJobRequest*, v1::Job*) override;
  Unary* DeleteJob(Wire*, const v1::DeleteJobRequest*, v1::DeleteJobResponse*) override;
  Stream<v1::JobEvent>* WatchJob(Wire*, const v1::WatchJobRequest*) override;

  // readings.cpp
  Unary* AppendReadings(Wire*, const v1::AppendReadingsRequest*,
                        v1::AppendReadingsResponse*) override;
  Unary* ForecastJob(Wire*, const v1::ForecastJobRequest*, v1::Forecast*) override;

  // preparations.cpp
  Unary* PrepareCasting(Wire*, const v1::PrepareCastingRequest*, v1::Preparation*) override;

  // lines.cpp
  Unary* ListLines(Wire*, const v1::ListLinesRequest*, v1::ListLinesResponse*) override;
  Unary* GetLine(Wire*, const v1::GetLineRequest*, v1::Line*) override;
  Unary* AddCastings(Wire*, const v1::AddCastingsRequest*, v1::AddCastingsResponse*) override;
  Unary* EditCasting(Wire*, const v1::EditCastingRequest*, v1::LineCasting*) override;
  Unary* ForgetCastings(Wire*, const v1::ForgetCastingsRequest*,
                        v1::ForgetCastingsResponse*) override;
  Unary* RestartLine(Wire*, const v1::RestartLineRequest*, v1::Line*) override;
  Unary* DeleteLine(Wire*, const v1::DeleteLineRequest*, v1::DeleteLineResponse*) override;

  // uploads.cpp
  grpc::ServerReadReactor<v1::UploadAttachmentRequest>* UploadAttachment(
      Wire*, v1::UploadAttachmentResponse*) override;

  // results.cpp
  Unary* QueryResult(Wire*, const v1::QueryResultRequest*, v1::QueryResultResponse*) override;
  Unary* ProbeResult(Wire*, const v1::ProbeResultRequest*, v1::ProbeResultResponse*) override;
  Stream<v1::FetchResultResponse>* FetchResult(Wire*, const v1::FetchResultRequest*) override;
  Stream<v1::FetchResultResponse>* FetchStudy(Wire*, const v1::FetchStudyRequest*) override;

  // queries.cpp
  Stream<v1::QueryButtCurlResponse>* QueryButtCurl(Wire*, const v1::QueryButtCurlRequest*) override;

  // comparisons.cpp
  Unary* CompareRuns(Wire*, const v1::CompareRunsRequest*, v1::Comparison*) override;

  // studies.cpp
  Unary* CreateStudy(Wire*, const v1::CreateStudyRequest*, v1::Study*) override;
  Unary* GetStudy(Wire*, const v1::GetStudyRequest*, v1::Study*) override;
  Unary* ListStudies(Wire*, const v1::ListStudiesRequest*, v1::ListStudiesResponse*) override;
  Unary* CancelStudy(Wire*, const v1::CancelStudyRequest*, v1::Study*) override;
  Unary* ResumeStudy(Wire*, const v1::ResumeStudyRequest*, v1::Study*) override;
  Unary* DeleteStudy(Wire*, const v1::DeleteStudyRequest*, v1::DeleteStudyResponse*) override;
  Unary* EvaluateStudy(Wire*, const v1::EvaluateStudyRequest*, v1::StudyResult*) override;
  Unary* JudgeStudy(Wire*, const v1::JudgeStudyRequest*, v1::StudyJudgement*) override;
  Unary* PredictStudy(Wire*, const v1::PredictStudyRequest*, v1::Prediction*) override;
  Stream<v1::Study>* WatchStudy(Wire*, const v1::WatchStudyRequest*) override;

private:
  /// The work of a call, run in a pool; throws a Refusal where the call is not answered.
  using Work = std::function<void(const Call&)>;
  /// One part of a call, and the pool in which it runs.
  struct Stage {
    /// Threads in which a stage runs.
    WorkPool& pool;
    Work work;
  };
  struct UnaryCall;

  /// Runs the stages of a call in turn, as long as its caller waits. An exception of a stage ends
  /// the call with the status that guarded() gives.
  /// @param request  lives as long as the call
  Unary* answer(Wire* wire, const google::protobuf::Message& request, std::vector<Stage> stages);
  /// Answers a call by one stage in a pool.
  Unary* answer(Wire* wire, const google::protobuf::Message& request, WorkPool& pool, Work work) {
    return answer(wire, request, {{pool, std::move(work)}});
  }
  /// Runs a stage and posts the next one, or finishes the call.
  void do_stage(std::shared_ptr<UnaryCall> call, std::size_t number);
  /// What the gate needs to know of a call, taken before its context may vanish.
  CallOrigin origin_of(const Wire* wire, const google::protobuf::Message& request) {
    return {*wire, context_.gate, request};
  }

  Context& context_;
  CallPools pools_;
};

}  // namespace dccast::service
