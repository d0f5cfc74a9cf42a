// PrepareCasting: what the forecast of a casting rests on (docs/following.md).
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/case_file/fingerprint.hpp"
#include "proto/case_file/override.hpp"
#include "proto/values/digests.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"
#include "server/service/submissions.hpp"

namespace dccast::service {
namespace {

constexpr int members = 64;
constexpr int most_pairs = 16;

/// By these labels the same casting finds its studies and the run of its plan again.
struct Labels {
  std::string ensemble, pairs, levers, plan;
};

Labels labels_of(const SoundSubmission& plan) {
  const auto digest = [&](case_file::Same same) {
    return intake::fingerprint(plan.examined.complete, same, plan.attachments).substr(0, 16);
  };
  // The studies have qualities of their own.
  const std::string casting = digest(case_file::Same::casting);
  return {"ensemble=" + casting, "pairs=" + casting, "levers=" + casting,
          "plan=" + digest(case_file::Same::answer)};
}

/// The newest study with a label that was not cancelled.
std::optional<v1::Study> labelled_study(Context& context, const std::string& owner,
                                        const std::string& label) {
  constexpr int most = 100;
  for (v1::Study& study :
       context.studies.requests().list({.size = most, .owner = owner, .labels = {label}}))
    if (study.state() != v1::STUDY_CANCELLED) return std::move(study);
  return std::nullopt;
}

bool has_ended(const v1::Study& study) {
  return !study.id().empty() && study.state() != v1::STUDY_RUNNING;
}

/// What there is of a preparation.
/// @param owner  whose entries the caller may read; empty: everyone's
v1::Preparation find_preparation(Context& context, const std::string& owner, const Labels& labels) {
  v1::Preparation found;
  const auto study = [&](const std::string& label) {
    return labelled_study(context, owner, label);
  };
  if (auto ensemble = study(labels.ensemble)) *found.mutable_ensemble() = std::move(*ensemble);
  // The others serve beside an ensemble alone.
  if (found.has_ensemble()) {
    if (auto pairs = study(labels.pairs)) *found.mutable_pairs() = std::move(*pairs);
    if (auto levers = study(labels.levers)) *found.mutable_levers() = std::move(*levers);
  }
  found.set_ready(has_ended(found.ensemble()) && has_ended(found.pairs()) &&
                  has_ended(found.levers()));

  const auto runs = context.store.list({.states = {v1::QUEUED, v1::RUNNING, v1::SUCCEEDED},
                                        .owner = owner,
                                        .labels = {labels.plan},
                                        .size = 1});
  if (!runs.empty()) found.set_plan_job(runs.front().job.id());
  return found;
}

/// Makes the runs of a study of this quality, whatever the case says.
void set_quality(v1::Quality quality, const char* name, v1::CreateStudyRequest& request) {
  request.mutable_case_()->set_quality(quality);
  *request.add_changes() = case_file::change_of("quality", name);
}

/// Drafts over all data of the case that have a range.
void lay_out_ensemble(v1::CreateStudyRequest& request) {
  set_quality(v1::DRAFT, "draft", request);
  v1::SweepPlan& sweep = *request.mutable_sweep();
  sweep.set_design(v1::SweepPlan::LATIN_HYPERCUBE);
  sweep.set_purpose(v1::SweepPlan::UNCERTAINTY);
  sweep.set_runs(members);
}

/// The data of the first members that count, once more at engineering quality.
void lay_out_pairs(const v1::StudyResult& ensemble, v1::CreateStudyRequest& request) {
  set_quality(v1::ENGINEERING, "engineering", request);
  v1::SweepPlan& sweep = *request.mutable_sweep();
  sweep.set_design(v1::SweepPlan::LIST);
  sweep.set_purpose(v1::SweepPlan::UNCERTAINTY);
  for (const auto& axis : ensemble.study().sweep().axes()) sweep.add_axes()->set_key(axis.key());

  int pairs = 0;
  for (const v1::StudyRun& run : ensemble.runs()) {
    if (run.state() != v1::SUCCEEDED || run.beyond_validity()) continue;
    for (int axis = 0; axis < sweep.axes_size(); ++axis)
      sweep.mutable_axes(axis)->add_values(run.values(axis));
    if (++pairs == most_pairs) return;
  }
  if (pairs == 0)
    refuse(ErrorInfo::WRONG_STATE,
           Remedy{"`dccast studies show` names the causes; mend the case or its ranges"},
           "no run of the ensemble counts, study {}", ensemble.study().id());
}

v1::StudyResult evaluated(Context& context, const std::string& id) {
  v1::EvaluateStudyRequest request;
  request.set_id(id);
  return of_study(id, context.studies.evaluation().evaluate(request));
}

/// A study to begin, and the label that finds it.
struct MissingStudy {
  std::string label;
  v1::CreateStudyRequest request;
  jobs::Attachments attachments;
};

/// The studies that are not there and can be begun now: pairs repeat members of an ensemble that
/// has ended, and levers are the last that a casting needs.
std::vector<MissingStudy> missing_studies(Context& context, const Labels& labels,
                                          const v1::Preparation& found,
                                          const v1::PrepareCastingRequest& preparation) {
  std::vector<MissingStudy> missing;
  const auto add = [&](const std::string& label) -> v1::CreateStudyRequest& {
    v1::CreateStudyRequest request;
    request.set_request_id(values::random_uuid());
    *request.mutable_case_() = preparation.case_();
    *request.mutable_attachments() = preparation.attachments();
    *request.mutable_changes() = preparation.changes();
    *request.mutable_labels() = preparation.labels();
    request.add_labels(label);
    return missing.emplace_back(MissingStudy{label, std::move(request), {}}).request;
  };

  if (!found.has_ensemble()) {
    lay_out_ensemble(add(labels.ensemble));
    return missing;
  }
  if (!has_ended(found.ensemble())) return missing;
  if (!found.has_pairs())
    lay_out_pairs(evaluated(context, found.ensemble().id()), add(labels.pairs));
  if (!found.has_levers()) add(labels.levers).mutable_levers();
  return missing;
}

/// The case as it is, as a job.
v1::SubmitJobRequest run_of_plan(const v1::PrepareCastingRequest& preparation) {
  v1::SubmitJobRequest run;
  run.set_request_id(values::random_uuid());
  *run.mutable_case_() = preparation.case_();
  *run.mutable_attachments() = preparation.attachments();
  *run.mutable_changes() = preparation.changes();
  run.set_case_file(preparation.case_file());
  // The forecast of a casting that begins waits for this run.
  if (preparation.begins_now()) run.set_priority(v1::HIGH);
  return run;
}

/// What the check of a preparation found.
struct CheckedPreparation {
  v1::SubmitJobRequest plan;
  SoundSubmission sound;
  Labels labels;
  std::vector<MissingStudy> missing;
};

CheckedPreparation examine(Context& context, const Call& call,
                           const v1::PrepareCastingRequest& request) {
  check_labels(request.labels());
  CheckedPreparation checked{
      .plan = run_of_plan(request), .sound = {}, .labels = {}, .missing = {}};
  checked.sound = examine(context, call, checked.plan);
  checked.labels = labels_of(checked.sound);
  checked.plan.add_labels(checked.labels.plan);
  if (request.begins_now()) return checked;

  const auto found = find_preparation(context, owner_of_list(context, call, {}), checked.labels);
  checked.missing = missing_studies(context, checked.labels, found, request);
  for (MissingStudy& study : checked.missing)
    study.attachments = examine(context, call, study.request);
  return checked;
}

/// Begins what is missing, unless another call has begun it since the check.
v1::Preparation begin_missing(Context& context, const Call& call,
                              const CheckedPreparation& checked) {
  const std::string owner = owner_of_list(context, call, {});
  static std::mutex preparing;  // two calls for one casting begin its studies once
  const std::lock_guard lock(preparing);

  for (const MissingStudy& study : checked.missing)
    if (!labelled_study(context, owner, study.label))
      context.studies.requests().create(study.request, study.attachments, call.caller.name);

  if (find_preparation(context, owner, checked.labels).plan_job().empty()) {
    check_may_queue(context, call);
    submit(context, call, checked.plan, checked.sound);
  }
  return find_preparation(context, owner, checked.labels);
}

}  // namespace

Unary* SimulationService::PrepareCasting(Wire* wire, const v1::PrepareCastingRequest* request,
                                         v1::Preparation* response) {
  const auto checked = std::make_shared<CheckedPreparation>();
  const auto check = [=, this](const Call& call) { *checked = examine(context_, call, *request); };
  const auto keep = [=, this](const Call& call) {
    *response = begin_missing(context_, call, *checked);
    call.note->set_study(response->ensemble().id());
    call.note->set_job(response->plan_job());
  };
  return answer(wire, *request, {{pools_.checks, check}, {pools_.durable, keep}});
}

}  // namespace dccast::service
