// Calls about cases and the server itself.
#include <fmt/format.h>
#include <google/protobuf/stubs/common.h>
#include <grpcpp/grpcpp.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/case_file/slab_recipe.hpp"
#include "proto/values/printable.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/processes.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

Unary* SimulationService::ValidateCase(Wire* wire, const v1::ValidateCaseRequest* request,
                                       v1::ValidateCaseResponse* response) {
  return answer(wire, *request, pools_.checks, [=, this](const Call& call) {
    auto examined = context_.intake.examine(
        request->case_(), uploaded_files(context_, call, request->attachments()),
        {request->faulty_keys().begin(), request->faulty_keys().end()},
        waiting_time(call, context_.settings.checks().timeout_s()), true);
    *response = std::move(examined.verdict);
    if (response->faults().empty()) *response->mutable_complete() = std::move(examined.complete);
  });
}

namespace {

/// The case text of a slab. @throws Refusal  all faults of its figures
std::string write_slab(const v1::SlabStart& slab) {
  const auto made = case_file::new_case(
      {.slab = slab.size(), .alloy = slab.alloy(), .speed = slab.speed(), .water = slab.water()});
  if (!made.faults.empty())
    refuse("{}", values::escaped(fmt::format("{}", fmt::join(made.faults, "; "))));
  return made.text;
}

/// Case text that a request carries or names, or that of its case. @throws Refusal  NOT_FOUND: no
/// such shipped case
std::string find_case_text(const v1::ReadCaseRequest& request) {
  if (request.has_case_()) return case_file::to_toml(request.case_());
  if (request.has_slab()) return write_slab(request.slab());
  if (request.source_case() != v1::ReadCaseRequest::kShipped) return request.text();
  const auto& cases = shipped::case_templates();
  if (const auto* known = shipped::find(cases, request.shipped())) return known->text;
  refuse(ErrorInfo::NOT_FOUND, "no case called \"{}\" is built in; there are {}",
         values::shown(request.shipped()), fmt::join(shipped::names_of(cases), ", "));
}

}  // namespace

Unary* SimulationService::ReadCase(Wire* wire, const v1::ReadCaseRequest* request,
                                   v1::ReadCaseResponse* response) {
  return answer(wire, *request, pools_.histories, [=](const Call&) {
    if (request->has_case_())
      for (v1::Fault& fault : case_file::check_ranges(request->case_())) {
        response->add_lines(0);
        intake::make_printable(*response->add_faults() = std::move(fault));
      }
    if (!response->faults().empty()) return;

    response->set_text(find_case_text(*request));
    auto read = case_file::read_elsewhere(response->text(), "case", *response->mutable_case_());

    // A text that is not TOML has one fault without a field, and no key that could be changed.
    const bool parsed = read.faults.size() != 1 || !read.faults.front().field().empty();
    if (parsed)
      case_file::apply_changes_elsewhere(
          *response->mutable_case_(), {request->changes().begin(), request->changes().end()}, read);

    for (const v1::Fault& fault : read.faults) {
      // Each fault carries the line where its key stands in the text.
      response->add_lines(read.source.find(fault.field()).line);
      intake::make_printable(*response->add_faults() = fault);
    }

    response->mutable_files()->Assign(read.files.begin(), read.files.end());
    if (!read.ok()) return;

    v1::Case& complete = *response->mutable_complete() = response->case_();
    case_file::apply_defaults(complete);
    response->set_summary(case_file::casting_summary(complete));
    for (v1::Chart& chart : case_file::planned_charts(complete))
      *response->add_charts() = std::move(chart);
  });
}

Unary* SimulationService::ListAlloys(Wire* wire, const v1::ListAlloysRequest* request,
                                     v1::ListAlloysResponse* response) {
  return answer(wire, *request, pools_.status, [=, this](const Call&) {
    const auto& alloys = context_.intake.alloys();
    response->mutable_alloys()->Assign(alloys.begin(), alloys.end());
  });
}

Unary* SimulationService::GetServerInfo(Wire* wire, const v1::GetServerInfoRequest* request,
                                        v1::GetServerInfoResponse* response) {
  return answer(wire, *request, pools_.status, [=, this](const Call&) {
    const intake::Ceilings& ceilings = context_.intake.ceilings();

    response->set_version(context_.version);
    response->set_workers(context_.workers);
    response->set_queued(context_.scheduler.queued());
    response->set_running(context_.scheduler.running());

    // Load of the server, and what the operator must repair.
    response->set_maximum_message_bytes(request_bytes);
    response->set_maximum_queued(context_.settings.limits().maximum_queued());
    response->set_storage_fault(context_.scheduler.held());
    response->set_quarantined(
        static_cast<int>(jobs::quarantined_folders(context_.jobs_directory).size()));
    response->set_paused(context_.store.count(v1::PAUSED));
    response->set_memory_bytes(jobs::resident_bytes("self"));

    for (const auto& [name, total] : jobs::child_processes()) {
      response->set_worker_processes(response->worker_processes() + total.number);
      response->set_worker_memory_bytes(response->worker_memory_bytes() + total.resident_bytes);
    }

    // Limits that a client can check a case against before it submits.
    response->set_maximum_nodes(ceilings.nodes);
    response->set_maximum_steps(ceilings.steps);
    response->set_maximum_memory_bytes(ceilings.memory_bytes);
    response->set_worker_sandbox(context_.worker_sandbox);

    response->set_build(
        fmt::format("g++ {}, gRPC {}, protobuf {}", __VERSION__, grpc::Version(),
                    google::protobuf::internal::VersionString(GOOGLE_PROTOBUF_VERSION)));
  });
}

}  // namespace dccast::service
