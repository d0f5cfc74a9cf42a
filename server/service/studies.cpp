// Calls about studies. Their table as a file is in results.cpp.
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/jobs/events.hpp"
#include "server/service/message_stream.hpp"
#include "server/service/request_checks.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

namespace {

// Of a long sweep so many runs are checked before it is taken; one that is refused later fails.
constexpr int most_checked = 24;

grpc::Status check_texts(const v1::CreateStudyRequest& request) {
  if (const auto status = check_text("request_id", request.request_id()); !status.ok())
    return status;
  if (const auto status = check_labels(request.labels()); !status.ok()) return status;
  return check_changes(request.changes());
}

grpc::Status check_plan(const v1::CreateStudyRequest& request) {
  v1::ValidateCaseResponse verdict;
  for (v1::Fault& fault : studies::plan_faults(request)) *verdict.add_faults() = std::move(fault);
  return verdict.faults_size() > 0 ? faulty_case(verdict) : grpc::Status::OK;
}

/// The verdict with the name of the run in front.
grpc::Status faulty_run(const std::string& name, const v1::ValidateCaseResponse& verdict) {
  const grpc::Status status = faulty_case(verdict);
  return {status.error_code(), name + ": " + status.error_message(), status.error_details()};
}

grpc::Status check_run(Context& context, const Call& call, const v1::CreateStudyRequest& request,
                       const studies::PlannedRun& run) {
  const auto examined = context.intake.examine(run.description, request.attachments(), {},
                                               waiting_time(call, context.check_timeout));
  if (examined.verdict.faults_size() == 0) return grpc::Status::OK;
  return faulty_run(run.name, examined.verdict);
}

/// CreateStudy's first half: everything that can be wrong with the plan and its cases.
grpc::Status examine(Context& context, const Call& call, const v1::CreateStudyRequest& request) {
  if (const auto status = check_texts(request); !status.ok()) return status;
  if (const auto status = check_plan(request); !status.ok()) return status;
  const auto plan = studies::study_plan(request);
  const int checked = std::min(plan->runs(), most_checked);
  for (int i = 0; i < checked; ++i) {
    // From the first run to the last.
    const int number = checked == 1 ? 0 : i * (plan->runs() - 1) / (checked - 1);
    if (const auto status = check_run(context, call, request, plan->run(number)); !status.ok())
      return status;
  }
  return grpc::Status::OK;
}

grpc::Status predict(Context& context, const v1::PredictStudyRequest& request,
                     v1::Prediction& response) {
  try {
    auto prediction = context.studies.predict(request);
    if (!prediction) return study_not_found(request.id());
    response = std::move(*prediction);
    return grpc::Status::OK;
  } catch (const studies::OutsideDomain& outside) {
    return {grpc::StatusCode::OUT_OF_RANGE, outside.what()};
  } catch (const studies::FaultyPlace& fault) {
    return {grpc::StatusCode::INVALID_ARGUMENT, fault.what()};
  } catch (const studies::CannotPredict& reason) {
    return {grpc::StatusCode::FAILED_PRECONDITION, reason.what()};
  }
}

/// The study each time it differs from what was sent last.
class StudyStream final : public MessageStream<v1::Study>, public studies::StudyWatcher {
public:
  StudyStream(WorkPool& lane, CallOrigin origin, Context& context, std::string id)
      : MessageStream(lane, std::move(origin)), context_(context), id_(std::move(id)) {}

  void on_changed() override { wake(); }

private:
  grpc::Status open(const Call&) override {
    if (const auto status = check_study_id(id_); !status.ok()) return status;
    if (!context_.studies.find(id_)) return study_not_found(id_);
    context_.studies.notifier().watch(id_,
                                      std::static_pointer_cast<StudyStream>(shared_from_this()));
    return grpc::Status::OK;
  }

  /// Looking a study up reads the store.
  bool looks_in_lane() const override { return true; }

  NextMessage<v1::Study> next() override {
    auto study = context_.studies.find(id_);
    if (!study) return {.end = study_not_found(id_)};
    const bool over = study->state() != v1::STUDY_RUNNING;
    const bool leaving = context_.leaving;
    if (!sent_ || !google::protobuf::util::MessageDifferencer::Equals(*sent_, *study)) {
      sent_ = *study;
      return {.message = std::move(*study)};
    }
    if (over) return {.end = grpc::Status::OK};
    if (!leaving) return {};
    return {.end = grpc::Status(
                grpc::StatusCode::UNAVAILABLE,
                "dccastd is shutting down; the study goes on when it is back: watch again")};
  }

  Context& context_;
  const std::string id_;
  std::optional<v1::Study> sent_;
};

}  // namespace

Unary* SimulationService::CreateStudy(Wire* wire, const v1::CreateStudyRequest* request,
                                      v1::Study* study) {
  const auto whole = std::make_shared<v1::CreateStudyRequest>();
  const auto check = [=, this](const Call& call) -> grpc::Status {
    const std::string& before = request->sweep().further_of();
    if (!before.empty())
      if (const auto status = check_study_id(before); !status.ok()) return status;
    if (!before.empty())
      if (const auto status = context_.gate.permit_touch(
              call.caller, access::rule_of(*v1::GetStudyRequest::descriptor()), before);
          !status.ok())
        return status;
    if (!context_.studies.complete(*request, *whole)) return study_not_found(before);
    if (const auto status = may_queue(context_, call); !status.ok()) return status;
    return examine(context_, call, *whole);
  };
  const auto create = [=, this](const Call& call) {
    *study = context_.studies.create(*whole, call.caller.name);
    call.note->set_study(study->id());
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.checks, check}, {lanes_.durable, create}});
}

Unary* SimulationService::GetStudy(Wire* wire, const v1::GetStudyRequest* request,
                                   v1::Study* study) {
  const auto work = [=, this](const Call&) {
    if (const auto status = check_study_id(request->id()); !status.ok()) return status;
    auto found = context_.studies.find(request->id());
    if (!found) return study_not_found(request->id());
    *study = std::move(*found);
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.status, work}});
}

Unary* SimulationService::ListStudies(Wire* wire, const v1::ListStudiesRequest* request,
                                      v1::ListStudiesResponse* response) {
  const auto work = [=, this](const Call& call) {
    AgePage page;
    if (const auto status =
            read_page("the list of studies", request->page_token(), request->page_size(), page);
        !status.ok())
      return status;
    // One more shows whether there is a next page.
    const bool own = context_.gate.authority().reads_own_only(call.caller);
    auto studies = context_.studies.list(
        {page.before_ms, page.before_id, page.size + 1, own ? call.caller.name : ""});
    const bool more = static_cast<int>(studies.size()) > page.size;
    if (more) studies.pop_back();
    for (v1::Study& study : studies) *response->add_studies() = std::move(study);
    if (!more) return grpc::Status::OK;
    const v1::Study& last = response->studies(page.size - 1);
    response->set_next_page_token(age_token(jobs::milliseconds(last.create_time()), last.id()));
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.status, work}});
}

Unary* SimulationService::CancelStudy(Wire* wire, const v1::CancelStudyRequest* request,
                                      v1::Study* study) {
  const auto work = [=, this](const Call&) {
    if (const auto status = check_study_id(request->id()); !status.ok()) return status;
    if (const auto status = check_text("reason", request->reason()); !status.ok()) return status;
    return status_of(context_.studies.cancel(request->id(), request->reason()), request->id(), "",
                     study);
  };
  return answer(wire, *request, {{lanes_.durable, work}});
}

Unary* SimulationService::ResumeStudy(Wire* wire, const v1::ResumeStudyRequest* request,
                                      v1::Study* study) {
  const auto work = [=, this](const Call&) {
    if (const auto status = check_study_id(request->id()); !status.ok()) return status;
    return status_of(context_.studies.resume(request->id(), request->failed()), request->id(), "",
                     study);
  };
  return answer(wire, *request, {{lanes_.durable, work}});
}

Unary* SimulationService::DeleteStudy(Wire* wire, const v1::DeleteStudyRequest* request,
                                      v1::DeleteStudyResponse*) {
  const auto work = [=, this](const Call&) {
    if (const auto status = check_study_id(request->id()); !status.ok()) return status;
    return status_of(context_.studies.remove(request->id()), request->id(),
                     "cancel it first, and wait until its jobs have ended", nullptr);
  };
  return answer(wire, *request, {{lanes_.durable, work}});
}

Unary* SimulationService::EvaluateStudy(Wire* wire, const v1::EvaluateStudyRequest* request,
                                        v1::StudyResult* response) {
  const auto work = [=, this](const Call&) {
    if (const auto status = check_study_id(request->id()); !status.ok()) return status;
    auto result = context_.studies.evaluate(*request);
    if (!result) return study_not_found(request->id());
    *response = std::move(*result);
    return grpc::Status::OK;
  };
  return answer(wire, *request, {{lanes_.histories, work}});
}

Unary* SimulationService::PredictStudy(Wire* wire, const v1::PredictStudyRequest* request,
                                       v1::Prediction* response) {
  const auto work = [=, this](const Call&) {
    if (const auto status = check_study_id(request->id()); !status.ok()) return status;
    return predict(context_, *request, *response);
  };
  return answer(wire, *request, {{lanes_.histories, work}});
}

SimulationService::Stream<v1::Study>* SimulationService::WatchStudy(
    Wire* wire, const v1::WatchStudyRequest* request) {
  return begin_stream<StudyStream>(lanes_.status, origin_of(wire, *request), context_,
                                   request->id());
}

}  // namespace dccast::service
