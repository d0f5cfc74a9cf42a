#include "fake_service.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>

#include <fmt/format.h>
#include <grpcpp/server_builder.h>

#include "server/judging/judged_comparison.hpp"
#include "server/judging/run_judgement.hpp"

namespace dccast::client {

namespace {

/// Local clients call Unix sockets only. The name is short: a path has at most 107 bytes.
std::string free_socket() {
  static std::atomic<int> count = 0;
  const auto path = std::filesystem::temp_directory_path() /
                    fmt::format("dccast-fake-{}-{}", ::getpid(), ++count);
  return fmt::format("unix:{}", path.string());
}

}  // namespace

FakeService::FakeService() : address_(free_socket()) {
  grpc::ServerBuilder builder;
  builder.AddListeningPort(address_, grpc::InsecureServerCredentials());
  builder.RegisterService(this);
  server_ = builder.BuildAndStart();
}

FakeService::~FakeService() {
  server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(2));
}

grpc::Status FakeService::WatchJob(grpc::ServerContext*, const v1::WatchJobRequest* request,
                                   grpc::ServerWriter<v1::JobEvent>* writer) {
  ++streams;
  if (request->id() != job.id()) return {grpc::StatusCode::NOT_FOUND, "no such job"};
  const auto from = std::max<std::int64_t>(1, request->from_sequence()) - 1;
  const auto begin = static_cast<std::size_t>(std::max<std::int64_t>(0, from - repeated_events));
  const auto end = std::min(events.size(), static_cast<std::size_t>(from) + events_per_stream);
  for (std::size_t i = begin; i < end; ++i) writer->Write(events[i]);
  return grpc::Status::OK;
}

grpc::Status FakeService::FetchResult(grpc::ServerContext*, const v1::FetchResultRequest* request,
                                      grpc::ServerWriter<v1::FetchResultResponse>* writer) {
  ++streams;
  const auto offset = static_cast<std::size_t>(request->offset());
  if (offset > artifact.size()) return {grpc::StatusCode::OUT_OF_RANGE, "beyond the end"};
  v1::FetchResultResponse chunk;
  chunk.set_offset(request->offset());
  chunk.set_total_size_bytes(static_cast<std::int64_t>(artifact.size()));
  chunk.set_sha256(artifact_sha256);
  chunk.set_data(artifact.substr(offset, bytes_per_stream));
  writer->Write(chunk);
  return grpc::Status::OK;
}

grpc::Status refusal_with(const v1::ValidateCaseResponse& verdict) {
  const refusal::Facts facts{.reason = v1::ErrorInfo::INVALID_CASE, .cause = "the case has faults"};
  return {grpc::INVALID_ARGUMENT, facts.message(),
          refusal::write_details(grpc::INVALID_ARGUMENT, facts, &verdict)};
}

grpc::Status FakeService::enter() {
  ++calls;
  if (unavailable.fetch_sub(1) > 0) return {grpc::StatusCode::UNAVAILABLE, "the check was killed"};
  return grpc::Status::OK;
}

grpc::Status FakeService::CancelJob(grpc::ServerContext*, const v1::CancelJobRequest* request,
                                    v1::Job* response) {
  if (const grpc::Status status = enter(); !status.ok()) return status;
  cancelled = *request;
  *response = job;
  return grpc::Status::OK;
}

/// A query of this case is answered with the steps of `result`.
grpc::Status FakeService::QueryButtCurl(grpc::ServerContext*,
                                        const v1::QueryButtCurlRequest* request,
                                        grpc::ServerWriter<v1::QueryButtCurlResponse>* writer) {
  std::string answer;
  {
    static std::mutex mutex;  // a comparison asks several at once
    const std::lock_guard lock(mutex);
    queried = *request;
    answer = std::to_string(answered_.size());
    answered_[answer] = request->case_();
  }
  if (verdict.faults_size() > 0) return refusal_with(verdict);
  v1::QueryButtCurlResponse response;
  *response.mutable_accepted()->mutable_case_() = request->case_();
  response.mutable_accepted()->set_answer(answer);
  writer->Write(response);
  for (const v1::StepReport& step : result.steps()) {
    *response.mutable_step() = step;
    writer->Write(response);
  }
  for (const v1::Finding& finding : result.findings()) {
    *response.mutable_finding() = finding;
    writer->Write(response);
  }
  response.mutable_ended()->set_state(job.state());
  response.mutable_ended()->set_solver_s(0.25);
  writer->Write(response);
  return grpc::Status::OK;
}

/// Judges as the server does; every run has the steps of `result`.
grpc::Status FakeService::CompareRuns(grpc::ServerContext*, const v1::CompareRunsRequest* request,
                                      v1::Comparison* comparison) {
  std::vector<judging::JudgedRun> runs;
  for (const v1::ComparedRun& asked : request->runs()) {
    const v1::Case& description = asked.has_job() ? result.case_() : answered_[asked.answer()];
    runs.push_back({{{result.steps().begin(), result.steps().end()}}, asked.name(), description});
    comparison->add_runs()->set_name(asked.name());
  }
  if (runs.size() > 1) {
    *comparison->mutable_judgement() = judging::judge_comparison(runs, {});
    return grpc::Status::OK;
  }
  if (result.steps().empty()) return {grpc::StatusCode::FAILED_PRECONDITION, "it has no step yet"};
  judging::RunToJudge alone{runs.front()};
  if (request->with_frame() && result.has_frame()) alone.last_frame = result.frame();
  if (job.has_validity_loss()) alone.valid_until_s = job.validity_loss().time_s();
  *comparison->mutable_judgement() = judging::judge_run(alone);
  return grpc::Status::OK;
}

grpc::Status FakeService::DeleteJob(grpc::ServerContext*, const v1::DeleteJobRequest* request,
                                    v1::DeleteJobResponse*) {
  if (deletions_aborted-- > 0) return {grpc::StatusCode::ABORTED, "it is being cancelled"};
  deleted.push_back(request->id());
  return grpc::Status::OK;
}

grpc::Status FakeService::ResumeJob(grpc::ServerContext*, const v1::ResumeJobRequest*,
                                    v1::Job* response) {
  if (const grpc::Status status = enter(); !status.ok()) return status;
  *response = job;
  return grpc::Status::OK;
}

grpc::Status FakeService::GetServerInfo(grpc::ServerContext*, const v1::GetServerInfoRequest*,
                                        v1::GetServerInfoResponse* response) {
  *response = info;
  return status_of_info;
}

grpc::Status FakeService::ValidateCase(grpc::ServerContext*, const v1::ValidateCaseRequest*,
                                       v1::ValidateCaseResponse* response) {
  if (const grpc::Status status = enter(); !status.ok()) return status;
  *response = verdict;
  return grpc::Status::OK;
}

grpc::Status FakeService::SubmitJob(grpc::ServerContext*, const v1::SubmitJobRequest* request,
                                    v1::Job* response) {
  if (const grpc::Status status = enter(); !status.ok()) return status;
  submitted = *request;
  *response = job;
  return grpc::Status::OK;
}

grpc::Status FakeService::GetJob(grpc::ServerContext*, const v1::GetJobRequest* request,
                                 v1::Job* response) {
  if (request->id() != job.id())
    return {grpc::StatusCode::NOT_FOUND, "there is no job " + request->id()};
  *response = job;
  return grpc::Status::OK;
}

grpc::Status FakeService::ListJobs(grpc::ServerContext*, const v1::ListJobsRequest* request,
                                   v1::ListJobsResponse* response) {
  listed = *request;
  if (listed_jobs.empty()) *response->add_jobs() = job;
  for (const v1::Job& one : listed_jobs)
    if (one.id().starts_with(request->id_prefix())) *response->add_jobs() = one;
  return grpc::Status::OK;
}

grpc::Status FakeService::QueryResult(grpc::ServerContext*, const v1::QueryResultRequest* request,
                                      v1::QueryResultResponse* response) {
  if (request->frame() && !result.has_frame())
    return {grpc::StatusCode::FAILED_PRECONDITION, "no frame yet"};
  // The token of a page is the number of its first step.
  const int from = request->page_token().empty() ? 0 : std::stoi(request->page_token());
  if (from > 0 && aborted_pages-- > 0)
    return {grpc::StatusCode::ABORTED, "steps were taken back; begin again"};
  *response = result;
  const int to = std::min(from + steps_per_page, result.steps_size());
  *response->mutable_steps() = {result.steps().begin() + from, result.steps().begin() + to};
  if (from > 0) response->clear_case_();
  if (to < result.steps_size()) response->set_next_page_token(std::to_string(to));
  return grpc::Status::OK;
}

std::vector<v1::JobEvent> run_of(int steps, v1::JobState end) {
  std::vector<v1::JobEvent> events(static_cast<std::size_t>(steps) + 3);
  events[0].mutable_state_change()->set_state(v1::QUEUED);
  events[1].mutable_state_change()->set_state(v1::RUNNING);
  for (int i = 1; i <= steps; ++i) {
    v1::StepReport& step = *events[static_cast<std::size_t>(i) + 1].mutable_step();
    step.set_step(i);
    step.set_time_s(i);
    step.set_cast_length_m(1e-3 * i);
    step.set_iterations(2);
    step.set_progress(static_cast<double>(i) / steps);
    step.set_solver_s(0.01 * i);
    v1::MonitorValue& corner = *step.add_monitors();
    corner.set_name("corner");
    corner.add_displacement_m(-1e-4 * i);
    corner.add_displacement_m(1e-3 * i);
    corner.set_curl_m(1e-3 * i);
    corner.set_judged(true);
  }
  auto& last = *events.back().mutable_state_change();
  last.set_state(end);
  last.set_terminal(true);
  if (end == v1::FAILED) last.mutable_failure()->set_message("the step fell below its minimum");
  for (std::size_t i = 0; i < events.size(); ++i)
    events[i].set_sequence(static_cast<std::int64_t>(i) + 1);
  return events;
}

}  // namespace dccast::client
