// Calls about cases and the server itself.
#include <google/protobuf/stubs/common.h>
#include <grpcpp/grpcpp.h>

#include "proto/case_file/override.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/values/printable.hpp"
#include "server/jobs/processes.hpp"
#include "server/jobs/quarantine.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

Unary* SimulationService::ValidateCase(Wire* wire, const v1::ValidateCaseRequest* request,
                                       v1::ValidateCaseResponse* response) {
  const auto work = [=, this](const Call& call) {
    auto examined =
        context_.intake.examine(request->case_(), request->attachments(),
                                {request->faulty_keys().begin(), request->faulty_keys().end()},
                                waiting_time(call, context_.check_timeout), true);
    *response = std::move(examined.verdict);
    if (response->faults().empty()) *response->mutable_complete() = std::move(examined.complete);
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.checks, work}});
}

namespace {

/// The text that a request gives or names. NOT_FOUND for a name that is not shipped.
grpc::Status find_text(const v1::ReadCaseRequest& request, std::string& text) {
  if (request.source_case() != v1::ReadCaseRequest::kShipped) {
    text = request.text();
    return grpc::Status::OK;
  }
  const auto& cases = shipped::case_templates();
  if (const auto* known = shipped::find(cases, request.shipped())) {
    text = known->text;
    return grpc::Status::OK;
  }
  std::string names;
  for (const std::string& name : shipped::names_of(cases))
    names += (names.empty() ? "" : ", ") + name;
  return {grpc::StatusCode::NOT_FOUND, "no case called \"" +
                                           values::escaped(values::shortened(request.shipped())) +
                                           "\" is built in; there are " + names};
}

}  // namespace

Unary* SimulationService::ReadCase(Wire* wire, const v1::ReadCaseRequest* request,
                                   v1::ReadCaseResponse* response) {
  const auto work = [=](const Call&) {
    std::string text;
    if (auto status = find_text(*request, text); !status.ok()) return status;
    auto read = case_file::read_elsewhere(text, "case", *response->mutable_case_());
    const bool parsed = read.faults.size() != 1 || !read.faults.front().field().empty();
    if (parsed)
      case_file::apply_changes_elsewhere(
          *response->mutable_case_(), {request->changes().begin(), request->changes().end()}, read);
    for (const v1::Fault& fault : read.faults) {
      *response->add_faults() = fault;
      response->add_lines(read.source.find(fault.field()).line);
    }
    response->mutable_files()->Assign(read.files.begin(), read.files.end());
    for (v1::Fault& fault : *response->mutable_faults()) intake::make_printable(fault);
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.histories, work}});
}

Unary* SimulationService::ListAlloys(Wire* wire, const v1::ListAlloysRequest* request,
                                     v1::ListAlloysResponse* response) {
  const auto work = [=, this](const Call&) {
    for (const v1::Alloy& alloy : context_.intake.alloys()) *response->add_alloys() = alloy;
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.status, work}});
}

Unary* SimulationService::GetServerInfo(Wire* wire, const v1::GetServerInfoRequest* request,
                                        v1::GetServerInfoResponse* response) {
  const auto work = [=, this](const Call&) {
    const intake::Ceilings& ceilings = context_.intake.ceilings();
    response->set_version(context_.version);
    response->set_workers(context_.workers);
    response->set_queued(context_.scheduler.queued());
    response->set_running(context_.scheduler.running());
    response->set_maximum_message_bytes(context_.maximum_message_bytes);
    response->set_maximum_queued(context_.maximum_queued);
    response->set_storage_fault(context_.scheduler.held());
    response->set_quarantined(
        static_cast<int>(jobs::quarantined_folders(context_.jobs_directory).size()));
    response->set_paused(context_.store.count(v1::PAUSED));
    response->set_memory_bytes(jobs::resident_bytes("self"));
    for (const auto& [name, total] : jobs::child_processes()) {
      response->set_worker_processes(response->worker_processes() + total.number);
      response->set_worker_memory_bytes(response->worker_memory_bytes() + total.resident_bytes);
    }
    response->set_maximum_nodes(ceilings.nodes);
    response->set_maximum_steps(ceilings.steps);
    response->set_maximum_memory_bytes(ceilings.memory_bytes);
    response->set_worker_sandbox(context_.worker_sandbox);
    // Pieced together with +=: g++ 12 sees a wrong overlap in operator+ here.
    std::string& build = *response->mutable_build() = "g++ ";
    build += __VERSION__;
    build += ", gRPC " + grpc::Version() + ", protobuf " +
             google::protobuf::internal::VersionString(GOOGLE_PROTOBUF_VERSION);
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.status, work}});
}

}  // namespace dccast::service
