// Calls about studies. Their table as a file is in results.cpp.
#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "proto/case_file/quality.hpp"
#include "proto/case_file/remedies.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/folder/job_description.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/judging/judged_study.hpp"
#include "server/service/line_answers.hpp"
#include "server/service/message_stream.hpp"
#include "server/service/refusals.hpp"
#include "server/service/run_history.hpp"
#include "server/service/simulation_service.hpp"
#include "server/service/submissions.hpp"
#include "server/studies/data_axes.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

namespace {

// So many runs of a long sweep are checked before it is accepted; faulty ones among the rest fail.
constexpr int most_checked = 24;

/// A request may name studies beside the one that it is about.
/// @throws Refusal  the caller may not read the study, or it is no study id
void check_may_read_study(Context& context, const Call& call, const std::string& id) {
  check_study_id(id);
  const auto& reading = access::rule_of(*v1::GetStudyRequest::descriptor());
  if (const auto status = context.gate.permit_touch(call.caller, reading, id); !status.ok())
    throw Refusal{status};
}

void check_may_read_castings(
    Context& context, const Call& call,
    const google::protobuf::RepeatedPtrField<v1::CalibratedCasting>& castings) {
  for (const v1::CalibratedCasting& casting : castings)
    for (const std::string& study : casting.studies()) check_may_read_study(context, call, study);
}

/// Findings of a job that a lever of the plant influences, the gravest first.
/// @throws Refusal  there is none, or the job has not ended
google::protobuf::RepeatedPtrField<v1::Finding> findings_to_remedy(const v1::Job& job) {
  if (!jobs::is_terminal(job.state())) refuse_state(job, "ask for a remedy when it has ended");

  google::protobuf::RepeatedPtrField<v1::Finding> findings;
  for (const v1::Finding& finding : job.findings())
    if (finding.severity() > v1::Finding::NOTE && !case_file::advice_against(finding).empty())
      *findings.Add() = finding;
  if (findings.empty())
    refuse(ErrorInfo::WRONG_STATE,
           "job {} has no finding that a lever of the plant influences (docs/findings.md)",
           job.id());

  std::stable_sort(findings.begin(), findings.end(),
                   [](const auto& a, const auto& b) { return a.severity() > b.severity(); });
  return findings;
}

/// Completes a request for a remedy with case, files and findings of its job, which the caller must
/// be permitted to read. @return  the files that the case names
jobs::Attachments complete_remedy(Context& context, const Call& call,
                                  v1::CreateStudyRequest& request) {
  const std::string id = request.remedy().job();
  *request.mutable_remedy()->mutable_findings() =
      findings_to_remedy(readable_job(context, call.caller, id));

  const auto folder = context.jobs_directory / id;
  const jobs::JobDescription description = jobs::read_job_description(folder);
  if (!request.mutable_case_()->ParseFromString(description.submitted_case))
    refuse(ErrorInfo::DAMAGED, "the case of job {} cannot be read any more", id);

  auto files = jobs::attachments_of(folder, description);
  *request.mutable_attachments() = named_files(files, id);
  return files;
}

/// The files that a request names; its plan gets the data of the case that have a range, where it
/// rests on them. @throws Refusal  the case has faults, or no ranges
jobs::Attachments complete_axes(Context& context, const Call& call,
                                v1::CreateStudyRequest& request) {
  auto attachments = uploaded_files(context, call, request.attachments());
  if (!studies::has_data_axes(request)) return attachments;

  v1::ValidateCaseResponse verdict;
  for (v1::Fault& fault : studies::lay_out_axes(context.intake, attachments, request))
    *verdict.add_faults() = std::move(fault);
  check_verdict(verdict);
  return attachments;
}

/// Completes a request for a remedy, or for further runs of a study with the case of that study,
/// which the caller must be permitted to read. @return  the files that the case names
jobs::Attachments complete(Context& context, const Call& call, v1::CreateStudyRequest& request) {
  if (request.has_remedy()) return complete_remedy(context, call, request);

  const std::string before = request.sweep().further_of();
  if (before.empty()) return complete_axes(context, call, request);

  check_may_read_study(context, call, before);
  auto attachments = context.studies.requests().complete(request);
  if (!attachments) throw Refusal{unknown_study(before)};
  return std::move(*attachments);
}

/// Checks the plan and the cases of its runs.
void check_runs(Context& context, const Call& call, const v1::CreateStudyRequest& request,
                const jobs::Attachments& attachments) {
  check_text("request_id", request.request_id());
  check_labels(request.labels());
  check_changes(request.changes());

  v1::ValidateCaseResponse verdict;
  for (v1::Fault& fault : studies::plan_faults(request)) *verdict.add_faults() = std::move(fault);
  check_verdict(verdict);

  const auto plan = studies::study_plan(request);
  const int checked = std::min(plan->runs(), most_checked);
  for (int i = 0; i < checked; ++i) {
    // Evenly spaced, with the first and the last run.
    const int number = checked == 1 ? 0 : i * (plan->runs() - 1) / (checked - 1);
    const studies::PlannedRun run = plan->run(number);
    const int refinement = request.has_refinement() ? run.description.mesh().refinement() : 0;
    sound_case(context, call, run.description, attachments, {run.name, refinement});
  }
}

/// The id under which an owner finds a study again by its plan and case.
std::string id_of_plan(Context& context, const Call& call, const v1::CreateStudyRequest& request) {
  const auto attachments = uploaded_files(context, call, request.attachments());
  const v1::Case complete = context.intake.complete_case(request.case_(), attachments).complete;

  v1::CreateStudyRequest plan = request;
  for (const char* key : {"case", "attachments", "priority", "labels", "changes"})
    plan.GetReflection()->ClearField(&plan, plan.GetDescriptor()->FindFieldByName(key));
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(plan, &text).ok())
    throw std::runtime_error("the plan cannot be written as JSON");
  return values::sha256(call.caller.name + "\n" + text + "\n" +
                        intake::fingerprint(complete, case_file::Same::input, attachments));
}

v1::Prediction predict(Context& context, const v1::PredictStudyRequest& request) {
  try {
    return of_study(request.id(), context.studies.surfaces().predict(request));
  } catch (const studies::OutsideDomain& outside) {
    refuse(ErrorInfo::OUT_OF_RANGE, "{}", outside.what());
  } catch (const studies::FaultyPlace& fault) {
    refuse("{}", fault.what());
  } catch (const studies::CannotPredict& reason) {
    refuse(ErrorInfo::WRONG_STATE, "{}", reason.what());
  }
}

/// Relative error of a small difference in curl between two runs of the study; empty if unknown.
std::optional<double> difference_error(Context& context, const v1::StudyResult& result) {
  const v1::StudyRun* const run = judging::first_valid_run(result);
  v1::Case complete;
  if (run == nullptr || !jobs::read_complete_case(context.jobs_directory / run->job(), complete))
    return std::nullopt;
  const auto paired = case_file::paired_error(complete, complete);
  return paired ? std::optional(paired->of_curl) : std::nullopt;
}

/// Index of the monitor whose curl is judged. @throws Refusal
int judged_monitor(const v1::StudyResult& result, const std::string& name) {
  const int monitor = judging::monitor_of(result, name);
  if (monitor >= 0) return monitor;
  if (result.monitors().empty()) refuse(ErrorInfo::NOT_FOUND, "the case has no monitor");
  refuse(ErrorInfo::NOT_FOUND, "no monitor named \"{}\"; there are: {}", name,
         fmt::join(result.monitors(), ", "));
}

/// A calibration with all further runs of its owner, oldest first.
v1::CalibratedCasting casting_of(Context& context, const v1::Study& calibration) {
  const std::string& id = calibration.id();
  std::vector<std::string> further;
  studies::StudyStore::Page page{.owner = calibration.owner()};
  for (bool found = false; !found;) {
    const auto newest_first = context.studies.requests().list(page);
    if (newest_first.empty()) break;
    for (const v1::Study& study : newest_first) {
      // All further studies are newer than what they belong to.
      found = found || study.id() == id;
      if (study.sweep().further_of() == id) further.push_back(study.id());
    }
    page.before_ms = jobs::milliseconds(newest_first.back().create_time());
    page.before_id = newest_first.back().id();
  }

  v1::CalibratedCasting casting;
  casting.add_studies(id);
  casting.mutable_studies()->Add(further.rbegin(), further.rend());
  return casting;
}

/// Whether the study alone says with which castings it is to be calibrated.
bool is_ended_calibration(const v1::Study& study) {
  return study.sweep().purpose() == v1::SweepPlan::CALIBRATION &&
         study.sweep().further_of().empty() && study.state() != v1::STUDY_RUNNING;
}

/// The runs of a study with their histories, in its order; those without a job are empty.
std::vector<judging::JudgedRun> judged_runs(Context& context, const v1::StudyResult& result) {
  std::vector<judging::JudgedRun> runs;
  for (const v1::StudyRun& run : result.runs()) {
    judging::JudgedRun& judged = runs.emplace_back();
    if (run.job().empty()) continue;

    judged.steps = read_steps(context, run.job());
    jobs::read_complete_case(context.jobs_directory / run.job(), judged.description);
  }
  return runs;
}

/// The case of a request as a file, with what the study found. @throws Refusal
std::string write_found_case(Context& context, const v1::JudgeStudyRequest& request,
                             const v1::StudyResult& result) {
  v1::CreateStudyRequest known;
  known.mutable_sweep()->set_further_of(request.id());
  context.studies.requests().complete(known);
  try {
    return judging::found_case(result, request.case_(), known.case_());
  } catch (const judging::UnfitCase& fault) {
    refuse("{}", fault.what());
  }
}

/// Adds what the castings of a line say of an uncertainty. @throws Refusal
void add_experience(Context& context, const Call& call, const v1::JudgeStudyRequest& request,
                    judging::StudyToJudge& study) {
  if (study.result.study().sweep().purpose() != v1::SweepPlan::UNCERTAINTY)
    refuse(Remedy{"ask about a study of `dccast uncertainty`"},
           "the castings of a line condition an uncertainty alone, and study {} is none",
           request.id());

  try {
    *study.result.mutable_experience() =
        ask_line(context, call, study.result, study.monitor, request.line(), request.assume_sound())
            .experience;
  } catch (const studies::CannotPredict& reason) {
    study.result.set_experience_fault(reason.what());
  }
}

void judge(Context& context, const Call& call, const v1::JudgeStudyRequest& request,
           v1::StudyJudgement& response) {
  v1::EvaluateStudyRequest evaluation;
  evaluation.set_id(request.id());
  evaluation.set_curves(request.with_curves());
  *evaluation.mutable_castings() = request.castings();
  const v1::Study asked = of_study(request.id(), context.studies.requests().find(request.id()));
  if (request.castings().empty() && is_ended_calibration(asked))
    *evaluation.add_castings() = casting_of(context, asked);

  judging::StudyToJudge study{
      of_study(request.id(), context.studies.evaluation().evaluate(evaluation))};
  const auto purpose = study.result.study().sweep().purpose();
  const bool is_remedy = study.result.study().has_remedy();
  if (is_remedy) study.monitor = judging::monitor_of(study.result, request.monitor());
  if (purpose == v1::SweepPlan::UNCERTAINTY || purpose == v1::SweepPlan::SENSITIVITY)
    study.monitor = judged_monitor(study.result, request.monitor());

  // An uncertainty is judged with its spread, which costs time and only this purpose needs.
  if (purpose == v1::SweepPlan::UNCERTAINTY) {
    evaluation.set_spread(study.result.monitors(study.monitor));
    study.result = of_study(request.id(), context.studies.evaluation().evaluate(evaluation));
  }

  if (!request.line().empty() || request.assume_sound())
    add_experience(context, call, request, study);

  if (is_remedy) study.runs = judged_runs(context, study.result);
  if (purpose == v1::SweepPlan::SENSITIVITY)
    study.difference_error = difference_error(context, study.result);

  *response.mutable_judgement() = judging::judge_study(study);
  *response.mutable_study() = study.result.study();
  if (request.has_case_()) response.set_case_file(write_found_case(context, request, study.result));
  if (request.with_result()) *response.mutable_result() = std::move(study.result);
}

/// Sends the study whenever it differs from what was sent last.
class StudyStream final : public MessageStream<v1::Study>, public studies::StudyWatcher {
public:
  StudyStream(WorkPool& pool, CallOrigin origin, Context& context, std::string id)
      : MessageStream(pool, std::move(origin)), context_(context), id_(std::move(id)) {}

  void on_changed() override { wake(); }

private:
  void open(const Call&) override {
    of_study(id_, context_.studies.requests().find(id_));
    context_.studies.notifier().watch(id_,
                                      std::static_pointer_cast<StudyStream>(shared_from_this()));
  }

  /// Reading a study reads the store.
  bool looks_in_pool() const override { return true; }

  NextMessage<v1::Study> next() override {
    auto study = of_study(id_, context_.studies.requests().find(id_));
    const bool over = study.state() != v1::STUDY_RUNNING;
    const bool leaving = context_.leaving;

    if (!sent_ || !google::protobuf::util::MessageDifferencer::Equals(*sent_, study)) {
      sent_ = study;
      return {.message = std::move(study)};
    }

    if (over) return {.end = grpc::Status::OK};
    if (leaving)
      refuse(ErrorInfo::SHUTTING_DOWN, Remedy{"the study goes on when it is back: watch again"},
             "dccastd is shutting down");
    return {};
  }

  Context& context_;
  const std::string id_;
  std::optional<v1::Study> sent_;
};

}  // namespace

jobs::Attachments examine(Context& context, const Call& call, v1::CreateStudyRequest& request) {
  const auto line = ask_line_of_plan(context, call, request);
  if (request.find()) request.set_request_id(id_of_plan(context, call, request));
  jobs::Attachments attachments = complete(context, call, request);
  if (line) take_line(*line, request);
  check_may_queue(context, call);
  check_runs(context, call, request, attachments);
  return attachments;
}

Unary* SimulationService::CreateStudy(Wire* wire, const v1::CreateStudyRequest* request,
                                      v1::Study* study) {
  const auto whole = std::make_shared<v1::CreateStudyRequest>(*request);
  const auto attachments = std::make_shared<jobs::Attachments>();

  const auto check = [=, this](const Call& call) {
    *attachments = examine(context_, call, *whole);
  };

  const auto create = [=, this](const Call& call) {
    *study = context_.studies.requests().create(*whole, *attachments, call.caller.name);
    call.note->set_study(study->id());
  };

  return answer(wire, *request, {{pools_.checks, check}, {pools_.durable, create}});
}

Unary* SimulationService::GetStudy(Wire* wire, const v1::GetStudyRequest* request,
                                   v1::Study* study) {
  return answer(wire, *request, pools_.status, [=, this](const Call&) {
    *study = of_study(request->id(), context_.studies.requests().find(request->id()));
  });
}

Unary* SimulationService::ListStudies(Wire* wire, const v1::ListStudiesRequest* request,
                                      v1::ListStudiesResponse* response) {
  return answer(wire, *request, pools_.status, [=, this](const Call& call) {
    check_labels(request->labels());
    const AgePage page =
        read_page("the list of studies", request->page_token(), request->page_size());

    // One study more than the page holds shows whether there is a next page.
    auto studies = context_.studies.requests().list(
        {.before_ms = page.before_ms,
         .before_id = page.before_id,
         .size = page.size + 1,
         .owner = owner_of_list(context_, call, request->owner()),
         .id_prefix = request->id_prefix(),
         .labels = {request->labels().begin(), request->labels().end()}});

    const bool more = static_cast<int>(studies.size()) > page.size;
    if (more) studies.pop_back();
    for (v1::Study& study : studies) *response->add_studies() = std::move(study);
    if (more) response->set_next_page_token(age_token(*response->studies().rbegin()));
  });
}

Unary* SimulationService::CancelStudy(Wire* wire, const v1::CancelStudyRequest* request,
                                      v1::Study* study) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    check_text("reason", request->reason());
    *study =
        done(context_.studies.requests().cancel(request->id(), request->reason()), request->id());
  });
}

Unary* SimulationService::ResumeStudy(Wire* wire, const v1::ResumeStudyRequest* request,
                                      v1::Study* study) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    *study =
        done(context_.studies.requests().resume(request->id(), request->failed()), request->id());
  });
}

Unary* SimulationService::DeleteStudy(Wire* wire, const v1::DeleteStudyRequest* request,
                                      v1::DeleteStudyResponse*) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    done(context_.studies.requests().remove(request->id()), request->id(),
         "cancel it first, and wait until its jobs have ended");
  });
}

Unary* SimulationService::EvaluateStudy(Wire* wire, const v1::EvaluateStudyRequest* request,
                                        v1::StudyResult* response) {
  return answer(wire, *request, pools_.histories, [=, this](const Call& call) {
    check_may_read_castings(context_, call, request->castings());
    *response = of_study(request->id(), context_.studies.evaluation().evaluate(*request));
  });
}

Unary* SimulationService::PredictStudy(Wire* wire, const v1::PredictStudyRequest* request,
                                       v1::Prediction* response) {
  return answer(wire, *request, pools_.histories,
                [=, this](const Call&) { *response = predict(context_, *request); });
}

Unary* SimulationService::JudgeStudy(Wire* wire, const v1::JudgeStudyRequest* request,
                                     v1::StudyJudgement* response) {
  return answer(wire, *request, pools_.histories, [=, this](const Call& call) {
    check_may_read_castings(context_, call, request->castings());
    judge(context_, call, *request, *response);
  });
}

SimulationService::Stream<v1::Study>* SimulationService::WatchStudy(
    Wire* wire, const v1::WatchStudyRequest* request) {
  return begin_stream<StudyStream>(pools_.status, origin_of(wire, *request), context_,
                                   request->id());
}

}  // namespace dccast::service
