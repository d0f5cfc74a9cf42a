#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dccast/v1/service.grpc.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/refusal/refusal.hpp"
#include "server/service/simulation_service.hpp"
#include "tests/unit/studies/studies_fixture.hpp"

namespace dccast::service {

using Stub = v1::SimulationService::Stub;

/// A user at an open connection.
class User {
public:
  template <class Request, class Response>
  using Method = grpc::Status (Stub::*)(grpc::ClientContext*, const Request&, Response*);
  template <class Request, class Response>
  using Stream = std::unique_ptr<grpc::ClientReader<Response>> (Stub::*)(grpc::ClientContext*,
                                                                         const Request&);

  User(const std::shared_ptr<grpc::Channel>& channel, std::string connection,
       std::string token = "")
      : stub_(v1::SimulationService::NewStub(channel)),
        connection_(std::move(connection)),
        token_(std::move(token)) {}

  /// The answer of a call that succeeds.
  template <class Request, class Response>
  Response ask(Method<Request, Response> method, const Request& request) const {
    Response response;
    const grpc::Status status = (stub_.get()->*method)(context().get(), request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }
  template <class Request, class Response>
  std::vector<Response> ask(Stream<Request, Response> method, const Request& request) const {
    std::vector<Response> all;
    const grpc::Status status = read(method, request, all);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return all;
  }

  /// The status of a call that is refused with a code.
  template <class Request, class Response>
  grpc::Status refusal(grpc::StatusCode code, Method<Request, Response> method,
                       const Request& request) const {
    Response response;
    return expected(code, (stub_.get()->*method)(context().get(), request, &response));
  }
  template <class Request, class Response>
  grpc::Status refusal(grpc::StatusCode code, Stream<Request, Response> method,
                       const Request& request) const {
    std::vector<Response> all;
    return expected(code, read(method, request, all));
  }

  /// Uploads the parts of a file.
  grpc::Status upload(const v1::Attachment& announced, const std::vector<std::string>& chunks,
                      v1::UploadAttachmentResponse* response = nullptr) const {
    v1::UploadAttachmentResponse unused;
    const auto call = context();
    const auto writer =
        stub_->UploadAttachment(call.get(), response == nullptr ? &unused : response);
    v1::UploadAttachmentRequest part;
    *part.mutable_attachment() = announced;
    bool taken = writer->Write(part);
    for (const std::string& chunk : chunks) {
      part.set_chunk(chunk);
      taken = taken && writer->Write(part);
    }
    writer->WritesDone();
    return writer->Finish();
  }
  v1::Attachment uploaded(const std::string& name, const std::string& content) const {
    v1::Attachment announced;
    announced.set_name(name);
    announced.set_sha256(values::sha256(content));
    announced.set_size_bytes(static_cast<std::int64_t>(content.size()));
    const grpc::Status status = upload(announced, {content});
    EXPECT_TRUE(status.ok()) << status.error_message();
    return announced;
  }

  /// A call of this user, for streams that a test holds open.
  std::unique_ptr<grpc::ClientContext> context() const {
    auto call = std::make_unique<grpc::ClientContext>();
    call->set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(30));
    call->AddMetadata(relay::connection_header, connection_);
    if (!token_.empty()) call->AddMetadata("authorization", "Bearer " + token_);
    return call;
  }
  Stub& stub() const { return *stub_; }

private:
  template <class Request, class Response>
  grpc::Status read(Stream<Request, Response> method, const Request& request,
                    std::vector<Response>& all) const {
    const auto call = context();
    const auto reader = (stub_.get()->*method)(call.get(), request);
    Response response;
    while (reader->Read(&response)) all.push_back(response);
    return reader->Finish();
  }
  /// Every refusal says why, to people and in the parts that programs read.
  static grpc::Status expected(grpc::StatusCode code, const grpc::Status& status) {
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    EXPECT_FALSE(status.error_message().empty());
    const auto facts = refusal::read_details(status.error_details());
    EXPECT_TRUE(facts && facts->message() == status.error_message()) << status.error_message();
    return status;
  }

  std::unique_ptr<Stub> stub_;
  std::string connection_, token_;
};

/// The calls of the service in this process, without daemon and relay. The test plays the workers
/// of jobs, and a program stands for the worker that checks cases.
class ServiceTest : public studies::StudiesTest {
protected:
  /// A change of the default settings.
  using Change = std::function<void(v1::DaemonConfig&)>;

  explicit ServiceTest(const Change& change = {}, const char* checker = finds_no_fault)
      : StudiesTest(checker), settings_(settings(change)) {
    // Not gRPC's channel within a process, on which a call that ends before its client has sent all
    // never ends for the client.
    const std::string address = "unix:" + (folder_ / "socket").string();
    grpc::ServerBuilder builder;
    builder.AddListeningPort(address, grpc::InsecureServerCredentials());
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    channel_ = grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
    queue_.scheduler.start();
  }
  ~ServiceTest() override {
    context_.leaving = true;
    server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
    server_->Wait();
  }

  /// The user of this process, who is an admin, at a socket of this machine.
  User local_user() {
    return {channel_, gate_.peers().add(std::make_shared<relay::Peer>(
                          relay::Peer{.host = "", .address = "unix:", .user_id = ::geteuid()}))};
  }
  /// A listed user of another machine, with a token.
  User remote_user(const std::string& name, v1::Role role = v1::SUBMITTER) {
    const std::int64_t now = std::time(nullptr);
    std::string token;
    users_.enrol(users_.add(name, role, now, now + 1000), "desk", now, now + 1000, token);
    return stranger(token);
  }
  /// Anyone on another machine.
  User stranger(const std::string& token = "") {
    return {channel_,
            gate_.peers().add(std::make_shared<relay::Peer>(relay::Peer{
                .host = "192.0.2.1", .address = "ipv4:192.0.2.1:40000", .over_tls = true})),
            token};
  }

  static v1::SubmitJobRequest submission(const std::string& title = "a casting") {
    v1::SubmitJobRequest request;
    *request.mutable_case_() = sound_case(title);
    return request;
  }
  template <class Request>
  static Request of(const std::string& id) {
    Request request;
    request.set_id(id);
    return request;
  }
  v1::Job submitted(const User& user, const v1::SubmitJobRequest& request = submission()) const {
    return user.ask(&Stub::SubmitJob, request);
  }
  /// A job that has run to its end. @param steps  of its history
  v1::Job ended_job(const User& user, const v1::SubmitJobRequest& request = submission(),
                    const std::vector<v1::StepReport>& steps = {}) {
    const v1::Job job = submitted(user, request);
    run_next_job(steps);
    return job;
  }
  /// Ids of the jobs that a list shows.
  static std::vector<std::string> listed(const User& user,
                                         const v1::ListJobsRequest& request = {}) {
    std::vector<std::string> ids;
    const auto page = user.ask(&Stub::ListJobs, request);
    for (const v1::Job& job : page.jobs()) ids.push_back(job.id());
    return ids;
  }

private:
  static v1::DaemonConfig settings(const Change& change) {
    v1::DaemonConfig settings;
    case_file::apply_defaults(settings);
    settings.mutable_checks()->set_workers(2);
    settings.mutable_queries()->set_workers(1);
    if (change) change(settings);
    return settings;
  }
  template <class Found>
  static std::optional<std::string> owner_of(const Found& found) {
    return found ? std::optional(found->owner()) : std::nullopt;
  }

protected:
  const v1::DaemonConfig settings_;
  access::UserStore users_{folder_.path()};
  access::AuditLog audit_{folder_.path()};
  studies::Studies studies_{options_, store_, queue_.scheduler, intake_};
  studies::Lines lines_{folder_ / "lines"};

private:
  access::Authority authority_{users_,
                               {.local_role = settings_.access().local_role(),
                                .own_user = user_name(::geteuid()),
                                .reads_own_only = settings_.access().read() == v1::OWN}};
  Gate gate_{authority_,
             audit_,
             {.calls_per_s = settings_.per_user().maximum_calls_per_s(),
              .streams = static_cast<std::size_t>(settings_.limits().maximum_streams()),
              .streams_per_user = static_cast<std::size_t>(settings_.per_user().maximum_streams())},
             {.job = [this](const auto& id) { return owner_of(queue_.scheduler.find(id)); },
              .study = [this](const auto& id) { return owner_of(studies_.requests().find(id)); },
              .line = [this](const auto& id) { return owner_of(lines_.find(id)); }}};
  jobs::ReadingsLogs readings_{options_.jobs_directory};
  intake::Uploads uploads_{
      folder_ / "uploads",
      {.largest = std::llround(settings_.per_case().maximum_attachment_bytes()),
       .of_user = std::llround(settings_.per_user().maximum_uploads_bytes()),
       .all = std::llround(settings_.limits().maximum_uploads_bytes()),
       .lifetime = std::chrono::milliseconds(
           std::llround(1000.0 * settings_.retention().upload_lifetime_s()))}};
  jobs::Precedence precedence_;
  Context context_{.settings = settings_,
                   .scheduler = queue_.scheduler,
                   .logs = queue_.logs,
                   .readings = readings_,
                   .store = queue_.store,
                   .studies = studies_,
                   .lines = lines_,
                   .intake = intake_,
                   .uploads = uploads_,
                   .gate = gate_,
                   .warm_workers = workers_,
                   .precedence = precedence_,
                   .solver = "",
                   .worker_sandbox = "",
                   .query_directory = folder_ / "check",
                   .jobs_directory = options_.jobs_directory,
                   .version = "1"};
  SimulationService service_{context_};
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace dccast::service
