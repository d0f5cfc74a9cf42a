#include "server/service/simulation_service.hpp"

#include <memory>
#include <utility>

#include "server/service/handlers.hpp"
#include "server/service/status.hpp"
#include "server/service/streams.hpp"

namespace dccast::service {

SimulationService::SimulationService(Context& context, studies::Studies& studies,
                                     const std::string& address)
    : context_(context),
      studies_{studies, context},
      users_(address),
      lanes_(context.checks_at_once, context.queries_at_once, context.maximum_waiting_checks) {}

void SimulationService::in_lane(WorkPool& lane, const Pending& pending,
                                std::function<grpc::Status(const Call&)> work,
                                std::function<void()> then) {
  auto turn = [this, pending, work = std::move(work), then = std::move(then)] {
    const grpc::Status status = guarded([&] {
      const Call call = call_of(*pending.wire, users_);
      const auto unwanted = no_longer_wanted(call);
      return unwanted ? *unwanted : work(call);
    });
    if (status.ok())
      then();
    else
      pending.reactor->Finish(status);
  };
  if (!lane.post(std::move(turn), pending.bytes)) pending.reactor->Finish(too_many_waiting());
}

template <class Of, class Request, class Response>
grpc::ServerUnaryReactor* SimulationService::answer(
    WorkPool& lane, Wire* wire, Of& context, const Request* request, Response* response,
    grpc::Status (*handler)(Of&, const Call&, const Request&, Response&)) {
  Unary* reactor = wire->DefaultReactor();
  in_lane(
      lane, {wire, reactor, request->ByteSizeLong()},
      [=, &context](const Call& call) { return handler(context, call, *request, *response); },
      [reactor] { reactor->Finish(grpc::Status::OK); });
  return reactor;
}

grpc::ServerUnaryReactor* SimulationService::ValidateCase(Wire* wire,
                                                          const v1::ValidateCaseRequest* request,
                                                          v1::ValidateCaseResponse* response) {
  return answer(lanes_.checks, wire, request, response, &validate_case);
}

grpc::ServerUnaryReactor* SimulationService::SubmitJob(Wire* wire,
                                                       const v1::SubmitJobRequest* request,
                                                       v1::Job* response) {
  const Pending pending{wire, wire->DefaultReactor(), request->ByteSizeLong()};
  const auto examined = std::make_shared<ExaminedCase>();
  const auto examine = [=, this](const Call& call) {
    return examine_submission(context_, call, *request, *examined);
  };
  const auto submit = [=, this](const Call& call) {
    return submit_job(context_, call, *request, *examined, *response);
  };
  in_lane(lanes_.checks, pending, examine, [=, this] {
    in_lane(lanes_.durable, pending, submit,
            [pending] { pending.reactor->Finish(grpc::Status::OK); });
  });
  return pending.reactor;
}

grpc::ServerUnaryReactor* SimulationService::GetJob(Wire* wire, const v1::GetJobRequest* request,
                                                    v1::Job* response) {
  return answer(lanes_.status, wire, request, response, &get_job);
}

grpc::ServerUnaryReactor* SimulationService::ListJobs(Wire* wire,
                                                      const v1::ListJobsRequest* request,
                                                      v1::ListJobsResponse* response) {
  return answer(lanes_.status, wire, request, response, &list_jobs);
}

grpc::ServerUnaryReactor* SimulationService::CancelJob(Wire* wire,
                                                       const v1::CancelJobRequest* request,
                                                       v1::Job* response) {
  return answer(lanes_.durable, wire, request, response, &cancel_job);
}

grpc::ServerUnaryReactor* SimulationService::PauseJob(Wire* wire,
                                                      const v1::PauseJobRequest* request,
                                                      v1::Job* response) {
  return answer(lanes_.durable, wire, request, response, &pause_job);
}

grpc::ServerUnaryReactor* SimulationService::ResumeJob(Wire* wire,
                                                       const v1::ResumeJobRequest* request,
                                                       v1::Job* response) {
  return answer(lanes_.durable, wire, request, response, &resume_job);
}

grpc::ServerUnaryReactor* SimulationService::DeleteJob(Wire* wire,
                                                       const v1::DeleteJobRequest* request,
                                                       v1::DeleteJobResponse* response) {
  return answer(lanes_.durable, wire, request, response, &delete_job);
}

grpc::ServerUnaryReactor* SimulationService::QueryResult(Wire* wire,
                                                         const v1::QueryResultRequest* request,
                                                         v1::QueryResultResponse* response) {
  WorkPool& lane = request->frame() ? lanes_.checks : lanes_.histories;
  return answer(lane, wire, request, response, &query_result);
}

grpc::ServerUnaryReactor* SimulationService::CreateStudy(Wire* wire,
                                                         const v1::CreateStudyRequest* request,
                                                         v1::Study* response) {
  const Pending pending{wire, wire->DefaultReactor(), request->ByteSizeLong()};
  const auto examine = [=, this](const Call& call) {
    return examine_study(studies_, call, *request);
  };
  const auto create = [=, this](const Call& call) {
    return create_study(studies_, call, *request, *response);
  };
  in_lane(lanes_.checks, pending, examine, [=, this] {
    in_lane(lanes_.durable, pending, create,
            [pending] { pending.reactor->Finish(grpc::Status::OK); });
  });
  return pending.reactor;
}

grpc::ServerUnaryReactor* SimulationService::GetStudy(Wire* wire,
                                                      const v1::GetStudyRequest* request,
                                                      v1::Study* response) {
  return answer(lanes_.status, wire, studies_, request, response, &get_study);
}

grpc::ServerUnaryReactor* SimulationService::ListStudies(Wire* wire,
                                                         const v1::ListStudiesRequest* request,
                                                         v1::ListStudiesResponse* response) {
  return answer(lanes_.status, wire, studies_, request, response, &list_studies);
}

grpc::ServerUnaryReactor* SimulationService::CancelStudy(Wire* wire,
                                                         const v1::CancelStudyRequest* request,
                                                         v1::Study* response) {
  return answer(lanes_.durable, wire, studies_, request, response, &cancel_study);
}

grpc::ServerUnaryReactor* SimulationService::ResumeStudy(Wire* wire,
                                                         const v1::ResumeStudyRequest* request,
                                                         v1::Study* response) {
  return answer(lanes_.durable, wire, studies_, request, response, &resume_study);
}

grpc::ServerUnaryReactor* SimulationService::DeleteStudy(Wire* wire,
                                                         const v1::DeleteStudyRequest* request,
                                                         v1::DeleteStudyResponse* response) {
  return answer(lanes_.durable, wire, studies_, request, response, &delete_study);
}

grpc::ServerUnaryReactor* SimulationService::EvaluateStudy(Wire* wire,
                                                           const v1::EvaluateStudyRequest* request,
                                                           v1::StudyResult* response) {
  return answer(lanes_.histories, wire, studies_, request, response, &evaluate_study);
}

grpc::ServerUnaryReactor* SimulationService::PredictStudy(Wire* wire,
                                                          const v1::PredictStudyRequest* request,
                                                          v1::Prediction* response) {
  return answer(lanes_.histories, wire, studies_, request, response, &predict_study);
}

grpc::ServerUnaryReactor* SimulationService::ListAlloys(Wire* wire,
                                                        const v1::ListAlloysRequest* request,
                                                        v1::ListAlloysResponse* response) {
  return answer(lanes_.status, wire, request, response, &list_alloys);
}

grpc::ServerUnaryReactor* SimulationService::GetServerInfo(Wire* wire,
                                                           const v1::GetServerInfoRequest* request,
                                                           v1::GetServerInfoResponse* response) {
  return answer(lanes_.status, wire, request, response, &get_server_info);
}

grpc::ServerWriteReactor<v1::JobEvent>* SimulationService::WatchJob(
    Wire* wire, const v1::WatchJobRequest* request) {
  return watch_job(context_, lanes_.status, StreamCall(*wire, users_), *request);
}

grpc::ServerWriteReactor<v1::FetchResultResponse>* SimulationService::FetchResult(
    Wire* wire, const v1::FetchResultRequest* request) {
  return fetch_result(context_, lanes_.status, StreamCall(*wire, users_), *request);
}

grpc::ServerWriteReactor<v1::FetchResultResponse>* SimulationService::FetchStudy(
    Wire* wire, const v1::FetchStudyRequest* request) {
  return fetch_study(studies_, lanes_.checks, StreamCall(*wire, users_), *request);
}

grpc::ServerWriteReactor<v1::Study>* SimulationService::WatchStudy(
    Wire* wire, const v1::WatchStudyRequest* request) {
  return watch_study(studies_, lanes_.status, StreamCall(*wire, users_), *request);
}

grpc::ServerWriteReactor<v1::QueryButtCurlResponse>* SimulationService::QueryButtCurl(
    Wire* wire, const v1::QueryButtCurlRequest* request) {
  return query_butt_curl(
      context_, lanes_.queries, [this, wire] { return call_of(*wire, users_); }, *request);
}

}  // namespace dccast::service
