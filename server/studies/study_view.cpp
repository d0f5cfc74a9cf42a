#include "server/studies/study_view.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "server/jobs/folder/events.hpp"

namespace dccast::studies {

namespace {

v1::StudyState state_of(const RunCounts& counts) {
  if (counts.ended() < counts.all()) return v1::STUDY_RUNNING;
  if (counts.of(v1::CANCELLED) > 0 || counts.all() == 0) return v1::STUDY_CANCELLED;
  return counts.of(v1::FAILED) > 0 ? v1::STUDY_FAILED : v1::STUDY_SUCCEEDED;
}

std::string message_of(const RunCounts& counts, v1::StudyState state) {
  if (counts.all() == 0) return "all jobs of the study were deleted";
  if (state == v1::STUDY_FAILED)
    return fmt::format("{} of {} runs failed", counts.of(v1::FAILED), counts.all());
  if (state == v1::STUDY_CANCELLED)
    return fmt::format("{} of {} runs were cancelled", counts.of(v1::CANCELLED), counts.all());
  return {};
}

void add_counts(const RunCounts& counts, v1::Study& study) {
  study.set_runs(counts.all());
  study.set_queued(counts.of(v1::QUEUED) + counts.of(v1::PAUSED));
  study.set_running(counts.of(v1::RUNNING));
  study.set_succeeded(counts.of(v1::SUCCEEDED));
  study.set_failed(counts.of(v1::FAILED));
  study.set_cancelled(counts.of(v1::CANCELLED));
}

void add_plan(const v1::CreateStudyRequest& request, v1::Study& study) {
  if (request.has_refinement()) *study.mutable_refinement() = request.refinement();
  if (request.has_sweep()) *study.mutable_sweep() = request.sweep();
  if (request.has_mould()) *study.mutable_mould() = request.mould();
  if (request.has_remedy()) *study.mutable_remedy() = request.remedy();
  if (request.has_levers()) *study.mutable_levers() = request.levers();
  if (request.has_recipe()) {
    *study.mutable_recipe() = request.recipe();
    // Large, and no list needs them.
    study.mutable_recipe()->clear_draft();
    study.mutable_recipe()->clear_members();
  }
}

/// Ended part of the study, 0 to 1. Running jobs count by their progress.
double progress_of(StudiesState& state, const StudyRecord& study, const RunCounts& counts) {
  double done = counts.ended();
  if (counts.of(v1::RUNNING) > 0)
    for (const v1::Job& job : state.scheduler.list({.states = {v1::RUNNING},
                              .study = study.id,
                              .owner = study.owner,
                              .size = counts.of(v1::RUNNING)}))
      done += job.last_step().progress();

  // The number of a recipe's runs is known before its later rounds are planned.
  const bool grows = study.request.has_recipe() && state_of(counts) == v1::STUDY_RUNNING;
  const int runs = grows ? state.plan_of(study)->most_runs() : counts.all();
  return runs == 0 ? 1.0 : std::min(1.0, done / runs);
}

}  // namespace

v1::Study study_view(StudiesState& state, const StudyRecord& study) {
  const RunCounts counts = state.store.counts(study.id);
  v1::Study view;
  view.set_id(study.id);
  view.set_title(study.request.case_().title());
  view.set_request_id(study.request.request_id());
  view.set_owner(study.owner);
  *view.mutable_create_time() = jobs::timestamp(study.created_ms);
  *view.mutable_labels() = study.request.labels();

  add_plan(study.request, view);
  add_counts(counts, view);
  view.set_state(state_of(counts));
  view.set_message(message_of(counts, view.state()));
  view.set_progress(progress_of(state, study, counts));

  // A mould design ends with the run that failed: show its reason.
  if (view.state() == v1::STUDY_FAILED && study.request.has_mould()) {
    const auto runs = state.runs_and_jobs(study);
    const auto failed = std::ranges::find(runs, v1::FAILED, &RunAndJob::state);
    if (failed != runs.end()) view.set_message(view.message() + ": " + failed->failure().message());
  }

  if (view.state() != v1::STUDY_RUNNING)
    *view.mutable_end_time() = jobs::timestamp(std::max(study.changed_ms, counts.last_end_ms));
  return view;
}

}  // namespace dccast::studies
