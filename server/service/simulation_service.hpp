#pragma once

#include "dccast/v1/service.grpc.pb.h"
#include "server/service/context.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// Hands every call of SimulationService to its handler. Callback API: no thread waits for a
/// stream.
class SimulationService final : public v1::SimulationService::CallbackService {
public:
  explicit SimulationService(Context& context) : context_(context) {}

  using Unary = grpc::ServerUnaryReactor;
  using Call = grpc::CallbackServerContext;
  Unary* ValidateCase(Call*, const v1::ValidateCaseRequest*, v1::ValidateCaseResponse*) override;
  Unary* SubmitJob(Call*, const v1::SubmitJobRequest*, v1::Job*) override;
  Unary* GetJob(Call*, const v1::GetJobRequest*, v1::Job*) override;
  Unary* ListJobs(Call*, const v1::ListJobsRequest*, v1::ListJobsResponse*) override;
  Unary* CancelJob(Call*, const v1::CancelJobRequest*, v1::Job*) override;
  Unary* PauseJob(Call*, const v1::PauseJobRequest*, v1::Job*) override;
  Unary* ResumeJob(Call*, const v1::ResumeJobRequest*, v1::Job*) override;
  Unary* DeleteJob(Call*, const v1::DeleteJobRequest*, v1::DeleteJobResponse*) override;
  Unary* QueryResult(Call*, const v1::QueryResultRequest*, v1::QueryResultResponse*) override;
  Unary* ListAlloys(Call*, const v1::ListAlloysRequest*, v1::ListAlloysResponse*) override;
  Unary* GetServerInfo(Call*, const v1::GetServerInfoRequest*, v1::GetServerInfoResponse*) override;
  grpc::ServerWriteReactor<v1::JobEvent>* WatchJob(Call*, const v1::WatchJobRequest*) override;
  grpc::ServerWriteReactor<v1::FetchResultResponse>* FetchResult(
      Call*, const v1::FetchResultRequest*) override;

private:
  template <class Request, class Response>
  Unary* answer(Call* call, const Request* request, Response* response,
                grpc::Status (*handler)(Context&, const Request&, Response&));

  Context& context_;
  WorkPool pool_{4};  ///< calls that fsync or examine a case; more would only wait for the disk
};

}  // namespace dccast::service
