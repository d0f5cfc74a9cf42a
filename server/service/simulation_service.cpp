#include "server/service/simulation_service.hpp"

#include "server/service/handlers.hpp"
#include "server/service/status.hpp"
#include "server/service/streams.hpp"

namespace dccast::service {

template <class Request, class Response>
grpc::ServerUnaryReactor* SimulationService::answer(
    Call* call, const Request* request, Response* response,
    grpc::Status (*handler)(Context&, const Request&, Response&)) {
  Unary* reactor = call->DefaultReactor();
  pool_.post([=, this] {
    reactor->Finish(guarded([&] { return handler(context_, *request, *response); }));
  });
  return reactor;
}

grpc::ServerUnaryReactor* SimulationService::ValidateCase(Call* call,
                                                          const v1::ValidateCaseRequest* request,
                                                          v1::ValidateCaseResponse* response) {
  return answer(call, request, response, &validate_case);
}

grpc::ServerUnaryReactor* SimulationService::SubmitJob(Call* call,
                                                       const v1::SubmitJobRequest* request,
                                                       v1::Job* response) {
  return answer(call, request, response, &submit_job);
}

grpc::ServerUnaryReactor* SimulationService::GetJob(Call* call, const v1::GetJobRequest* request,
                                                    v1::Job* response) {
  return answer(call, request, response, &get_job);
}

grpc::ServerUnaryReactor* SimulationService::ListJobs(Call* call,
                                                      const v1::ListJobsRequest* request,
                                                      v1::ListJobsResponse* response) {
  return answer(call, request, response, &list_jobs);
}

grpc::ServerUnaryReactor* SimulationService::CancelJob(Call* call,
                                                       const v1::CancelJobRequest* request,
                                                       v1::Job* response) {
  return answer(call, request, response, &cancel_job);
}

grpc::ServerUnaryReactor* SimulationService::PauseJob(Call* call,
                                                      const v1::PauseJobRequest* request,
                                                      v1::Job* response) {
  return answer(call, request, response, &pause_job);
}

grpc::ServerUnaryReactor* SimulationService::ResumeJob(Call* call,
                                                       const v1::ResumeJobRequest* request,
                                                       v1::Job* response) {
  return answer(call, request, response, &resume_job);
}

grpc::ServerUnaryReactor* SimulationService::DeleteJob(Call* call,
                                                       const v1::DeleteJobRequest* request,
                                                       v1::DeleteJobResponse* response) {
  return answer(call, request, response, &delete_job);
}

grpc::ServerUnaryReactor* SimulationService::QueryResult(Call* call,
                                                         const v1::QueryResultRequest* request,
                                                         v1::QueryResultResponse* response) {
  return answer(call, request, response, &query_result);
}

grpc::ServerUnaryReactor* SimulationService::ListAlloys(Call* call,
                                                        const v1::ListAlloysRequest* request,
                                                        v1::ListAlloysResponse* response) {
  return answer(call, request, response, &list_alloys);
}

grpc::ServerUnaryReactor* SimulationService::GetServerInfo(Call* call,
                                                           const v1::GetServerInfoRequest* request,
                                                           v1::GetServerInfoResponse* response) {
  return answer(call, request, response, &get_server_info);
}

grpc::ServerWriteReactor<v1::JobEvent>* SimulationService::WatchJob(
    Call*, const v1::WatchJobRequest* request) {
  return watch_job(context_, *request);
}

grpc::ServerWriteReactor<v1::FetchResultResponse>* SimulationService::FetchResult(
    Call*, const v1::FetchResultRequest* request) {
  return fetch_result(context_, *request);
}

}  // namespace dccast::service
