#include "server/studies/run_results.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "proto/figures/run_history.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/logs/step_index.hpp"

namespace dccast::studies {

namespace {

/// Describes a run by its job.
void describe_job(const v1::Job& job, v1::StudyRun& run) {
  run.set_job(job.id());
  run.set_state(job.state());
  *run.mutable_findings() = job.findings();
  if (job.has_failure()) *run.mutable_failure() = job.failure();
  run.set_solver_s(job.last_step().solver_s());
  run.set_nodes(job.last_step().nodes());
  run.set_beyond_validity(job.has_validity_loss());
}

void describe_without_job(const RunRecord& record, v1::StudyRun& run) {
  run.set_state(record.to_queue() ? v1::QUEUED : record.outcome);
  if (record.outcome == v1::FAILED) *run.mutable_failure() = record.failure;
}

/// @throws jobs::UnsoundResult  the job has none
const v1::Artifact& results_of(const v1::Job& job) {
  const auto found = std::ranges::find(job.artifacts(), "results.h5", &v1::Artifact::name);
  if (found != job.artifacts().end()) return *found;
  throw jobs::UnsoundResult("job " + job.id() + " has no results.h5; run it again");
}

}  // namespace

void hold_settled(const v1::Case& description, std::vector<EvaluatedRun>& runs) {
  if (!description.time().has_settled_m_per_s() || description.time().cool_down_s() > 0.0) return;
  double end_s = -INFINITY;
  for (const EvaluatedRun& run : runs)
    if (run.counts()) end_s = std::max(end_s, *run.history.curves.front().time_s().rbegin());
  for (EvaluatedRun& run : runs)
    if (run.counts()) run.history.hold_until(end_s);
}

void RunResults::forget(const std::string& job) {
  histories_.forget(job);
  faces_.forget(job);
}

RunCurves RunResults::history_of(const v1::Job& job) {
  if (const auto kept = histories_.find(job.id())) return *kept;

  const auto log = state_.scheduler.log(job.id());
  auto page = jobs::StepIndex().page(*log, {}, SIZE_MAX, SIZE_MAX).value();
  const auto history = std::make_shared<const RunCurves>(run_curves(job, std::move(page.steps)));

  // Only the history of an ended job cannot change any more.
  if (jobs::is_terminal(job.state())) histories_.keep(job.id(), history, history->bytes());
  return *history;
}

std::shared_ptr<const RunFace> RunResults::face_of(const v1::Job& job) {
  if (const auto kept = faces_.find(job.id())) return kept;

  const auto folder = state_.options.jobs_directory / job.id();
  v1::Case complete;
  if (!jobs::read_complete_case(folder, complete))
    throw jobs::WorkerDidNotAnswer(jobs::WorkerDidNotAnswer::Why::refused,
                                   "the case of job " + job.id() + " cannot be read");

  const auto deadline = std::chrono::steady_clock::now() + state_.options.check_timeout;
  const auto last = state_.intake.stored_frame(folder, results_of(job), {}, {.deadline = deadline});

  const auto face = std::make_shared<const RunFace>(RunFace{
      complete.section(), frames::steady_face(frames::contraction_of(complete, last.frame()))});
  return faces_.keep(job.id(), face);
}

void RunResults::add_face(const v1::Job& job, EvaluatedRun& run) {
  try {
    run.face = *face_of(job);
  } catch (const frames::NoContraction& reason) {
    run.face_fault = reason.what();
  } catch (const jobs::UnsoundResult& unsound) {
    run.face_fault = unsound.what();
  } catch (const jobs::WorkerDidNotAnswer& error) {
    // Without a worker nothing is known of the face: the call can be repeated.
    if (error.why() == jobs::WorkerDidNotAnswer::Why::not_started) throw;
    run.face_fault = error.what();
  }
}

std::vector<EvaluatedRun> RunResults::evaluated_runs(const StudyRecord& study, const Depth& depth) {
  const auto plan = state_.plan_of(study);
  std::vector<EvaluatedRun> runs;

  for (const RunAndJob& each : state_.runs_and_jobs(study)) {
    const auto& [record, job] = each;
    if (record.number >= depth.before) break;
    if (each.deleted()) continue;

    EvaluatedRun& evaluated = runs.emplace_back();
    evaluated.number = record.number;
    plan->describe(record.number, evaluated.run);

    if (job)
      describe_job(*job, evaluated.run);
    else
      describe_without_job(record, evaluated.run);

    for (const v1::Monitor& monitor : study.request.case_().monitor())
      evaluated.run.add_end_curl_m(evaluated.succeeded() ? figures::curl_of(figures::monitor_of(
                                                               job->last_step(), monitor.name()))
                                                         : NAN);

    if (!evaluated.succeeded()) continue;
    if (depth.histories) evaluated.history = history_of(*job);
    if (depth.faces) add_face(*job, evaluated);
  }
  if (depth.histories) hold_settled(study.request.case_(), runs);
  return runs;
}

}  // namespace dccast::studies
