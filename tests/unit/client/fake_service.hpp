#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <grpcpp/server.h>

#include "client/session/connection.hpp"
#include "dccast/v1/service.grpc.pb.h"

namespace dccast::client {

/// Refuses a case with faults as dccastd does.
grpc::Status refusal_with(const v1::ValidateCaseResponse& verdict);

/// A daemon in the test's own process, on a free loopback port. It plays back what the test gives
/// it and misbehaves as it is told to.
class FakeService final : public v1::SimulationService::Service {
public:
  FakeService();
  ~FakeService() override;

  Connection connect() const { return Connection(Endpoint{.address = address_}); }
  const std::string& address() const { return address_; }

  // Answers.
  std::vector<v1::JobEvent> events;
  std::string artifact;
  std::string artifact_sha256;
  v1::ValidateCaseResponse verdict;
  v1::Job job;
  v1::QueryResultResponse result;
  std::vector<v1::Job> listed_jobs;  ///< in place of `job`, where there are some
  int deletions_aborted = 0;         ///< so many DeleteJob are answered ABORTED first

  // Simulated faults.
  std::size_t events_per_stream = 1000;  ///< a stream is cut after so many
  std::size_t bytes_per_stream = 1 << 30;
  std::atomic<int> unavailable{0};  ///< so many unary calls are answered UNAVAILABLE first
  int steps_per_page = 1000;
  int aborted_pages = 0;    ///< so many reads of a second page are answered ABORTED
  int repeated_events = 0;  ///< old events sent again at the beginning of a stream

  // Received requests.
  std::atomic<int> streams{0};
  std::atomic<int> calls{0};  ///< unary ones
  v1::CancelJobRequest cancelled;
  v1::SubmitJobRequest submitted;
  v1::ListJobsRequest listed;
  v1::QueryButtCurlRequest queried;
  std::vector<std::string> deleted;

  grpc::Status WatchJob(grpc::ServerContext*, const v1::WatchJobRequest*,
                        grpc::ServerWriter<v1::JobEvent>*) override;
  grpc::Status FetchResult(grpc::ServerContext*, const v1::FetchResultRequest*,
                           grpc::ServerWriter<v1::FetchResultResponse>*) override;
  grpc::Status ValidateCase(grpc::ServerContext*, const v1::ValidateCaseRequest*,
                            v1::ValidateCaseResponse*) override;
  grpc::Status SubmitJob(grpc::ServerContext*, const v1::SubmitJobRequest*, v1::Job*) override;
  grpc::Status GetJob(grpc::ServerContext*, const v1::GetJobRequest*, v1::Job*) override;
  grpc::Status ListJobs(grpc::ServerContext*, const v1::ListJobsRequest*,
                        v1::ListJobsResponse*) override;
  grpc::Status QueryResult(grpc::ServerContext*, const v1::QueryResultRequest*,
                           v1::QueryResultResponse*) override;

  grpc::Status QueryButtCurl(grpc::ServerContext*, const v1::QueryButtCurlRequest*,
                             grpc::ServerWriter<v1::QueryButtCurlResponse>*) override;
  grpc::Status CompareRuns(grpc::ServerContext*, const v1::CompareRunsRequest*,
                           v1::Comparison*) override;
  grpc::Status DeleteJob(grpc::ServerContext*, const v1::DeleteJobRequest*,
                         v1::DeleteJobResponse*) override;
  grpc::Status CancelJob(grpc::ServerContext*, const v1::CancelJobRequest*, v1::Job*) override;
  grpc::Status ResumeJob(grpc::ServerContext*, const v1::ResumeJobRequest*, v1::Job*) override;
  grpc::Status GetServerInfo(grpc::ServerContext*, const v1::GetServerInfoRequest*,
                             v1::GetServerInfoResponse*) override;
  v1::GetServerInfoResponse info;
  grpc::Status status_of_info;

private:
  /// Cases of the queries so far, by the name of their answer.
  std::map<std::string, v1::Case> answered_;
  /// Counts a unary call. @return UNAVAILABLE as often as the test wants it
  grpc::Status enter();
  std::string address_;
  std::unique_ptr<grpc::Server> server_;
};

/// A run of `steps` steps: queued, running, the steps, then the end.
std::vector<v1::JobEvent> run_of(int steps, v1::JobState end = v1::SUCCEEDED);

}  // namespace dccast::client
