// The results of studies: their runs with figures and curves, and what a plan makes of them.
#include <algorithm>
#include <chrono>
#include <climits>
#include <iterator>
#include <limits>

#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/studies/measured_castings.hpp"
#include "server/studies/studies.hpp"

namespace dccast::studies {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// A run that has a job.
void describe_job(const v1::Job& job, v1::StudyRun& run) {
  run.set_job(job.id());
  run.set_state(job.state());
  *run.mutable_findings() = job.findings();
  if (job.has_failure()) *run.mutable_failure() = job.failure();
  run.set_solver_s(job.last_step().solver_s());
  run.set_beyond_validity(job.has_validity_loss());
}

void describe_without_job(const RunRecord& record, v1::StudyRun& run) {
  run.set_state(record.to_queue() ? v1::QUEUED : record.outcome);
  if (record.outcome == v1::FAILED) *run.mutable_failure() = record.failure;
}

/// The curl at the end of a run, of every monitor of the case.
void add_end_curls(const v1::Case& base, const v1::Job& job, v1::StudyRun& run) {
  for (const v1::Monitor& monitor : base.monitor())
    run.add_end_curl_m(job.state() == v1::SUCCEEDED ? curl_at(job.last_step(), monitor.name())
                                                    : unknown);
}

std::size_t bytes_of(const RunHistory& history) {
  std::size_t bytes = 0;
  for (const v1::CurlCurve& curve : history.curves) bytes += curve.SpaceUsedLong();
  for (const auto& [monitor, temperature_c] : history.temperature_c)
    bytes += temperature_c.size() * sizeof(double);
  return bytes;
}

}  // namespace

RunHistory Studies::history_of(const v1::Job& job) {
  if (const auto kept = histories_.find(job.id())) return *kept;
  const auto log = scheduler_.log(job.id());
  const auto page = jobs::StepIndex().page(*log, {}, SIZE_MAX, SIZE_MAX);
  const auto history =
      std::make_shared<const RunHistory>(page ? run_history(job, page->steps) : RunHistory{});
  if (jobs::is_terminal(job.state())) histories_.keep(job.id(), history, bytes_of(*history));
  return *history;
}

/// The last frame of a run is read once and its face kept.
/// @throws jobs::WorkerDidNotAnswer, frames::NoContraction
std::shared_ptr<const RunFace> Studies::face_of(const v1::Job& job) {
  if (const auto kept = faces_.find(job.id())) return kept;
  v1::Case complete;
  if (!jobs::read_complete_case(options_.jobs_directory / job.id(), complete))
    throw jobs::WorkerDidNotAnswer(jobs::WorkerDidNotAnswer::Why::refused,
                                   "the case of job " + job.id() + " cannot be read");
  const auto last =
      intake_.stored_frame(options_.jobs_directory / job.id(), 0,
                           {.deadline = std::chrono::steady_clock::now() + options_.check_timeout});
  const auto face = std::make_shared<const RunFace>(RunFace{
      complete.section(), frames::steady_face(frames::contraction_of(complete, last.frame()))});
  return faces_.keep(job.id(), face);
}

void Studies::add_face(const v1::Job& job, EvaluatedRun& run) {
  try {
    run.face = *face_of(job);
  } catch (const frames::NoContraction& reason) {
    run.face_fault = reason.what();
  } catch (const jobs::WorkerDidNotAnswer& error) {
    if (error.why() == jobs::WorkerDidNotAnswer::Why::not_started) throw;
    run.face_fault = error.what();
  }
}

/// Runs whose job was deleted are left out.
std::vector<EvaluatedRun> Studies::evaluated_runs(const StudyRecord& record, const Depth& depth) {
  const auto plan = plan_of(record);
  const auto jobs = jobs_of(record.id);
  std::vector<EvaluatedRun> runs;
  for (const RunRecord& kept : store_.runs(record.id)) {
    if (kept.number >= depth.before) break;
    const auto job = jobs.find(kept.job);
    if (!kept.job.empty() && job == jobs.end()) continue;
    EvaluatedRun& evaluated = runs.emplace_back();
    evaluated.number = kept.number;
    plan->describe(kept.number, evaluated.run);
    if (kept.job.empty()) {
      describe_without_job(kept, evaluated.run);
      add_end_curls(record.request.case_(), {}, evaluated.run);
      continue;
    }
    describe_job(job->second, evaluated.run);
    add_end_curls(record.request.case_(), job->second, evaluated.run);
    if (!evaluated.succeeded()) continue;
    if (depth.histories) evaluated.history = history_of(job->second);
    if (depth.faces) add_face(job->second, evaluated);
  }
  return runs;
}

/// Why the first run that failed did.
std::string Studies::failure_text(const StudyRecord& record) {
  for (const EvaluatedRun& evaluated : evaluated_runs(record, {}))
    if (evaluated.run.state() == v1::FAILED) return evaluated.run.failure().message();
  return {};
}

void Studies::add_spread(const StudyRecord& record, const std::string& monitor,
                         v1::StudyResult& result) {
  const RunCounts counts = store_.counts(record.id);
  try {
    *result.mutable_spread() =
        predictions_.spread(record, counts.of(v1::SUCCEEDED), counts.ended() < counts.all(),
                            monitor, [&] { return evaluated_runs(record, {.histories = true}); });
  } catch (const CannotPredict& reason) {
    result.set_spread_fault(reason.what());
  }
}

void Studies::add_calibration(const v1::EvaluateStudyRequest& request, v1::StudyResult& result) {
  try {
    std::vector<MeasuredCasting> castings;
    for (const v1::CalibratedCasting& asked : request.castings()) {
      MeasuredCasting& casting = castings.emplace_back();
      for (const std::string& id : asked.studies()) {
        const auto record = store_.find(id);
        if (!record || !record->request.has_sweep()) throw CannotPredict("there is no sweep " + id);
        auto runs = evaluated_runs(*record, {.histories = true});
        if (casting.runs.empty())
          casting.request = record->request;
        else
          casting.last = static_cast<int>(runs.size());
        std::ranges::move(runs, std::back_inserter(casting.runs));
      }
    }
    *result.mutable_calibration() = calibration_of(std::move(castings));
  } catch (const CannotPredict& reason) {
    result.set_calibration_fault(reason.what());
  }
}

std::optional<v1::StudyResult> Studies::evaluate(const v1::EvaluateStudyRequest& request) {
  const auto record = store_.find(request.id());
  const bool curves = request.curves();
  if (!record) return std::nullopt;
  const auto plan = plan_of(*record);
  auto runs = evaluated_runs(
      *record, {.histories = curves || plan->needs_histories(), .faces = plan->needs_faces()});
  v1::StudyResult result;
  *result.mutable_study() = view(*record);
  for (const v1::Monitor& monitor : record->request.case_().monitor())
    result.add_monitors(monitor.name());
  plan->evaluate(runs, result);
  if (!request.spread().empty()) add_spread(*record, request.spread(), result);
  if (!request.castings().empty()) add_calibration(request, result);
  for (EvaluatedRun& evaluated : runs) {
    v1::StudyRun& run = *result.add_runs() = std::move(evaluated.run);
    if (curves)
      for (v1::CurlCurve& curve : evaluated.history.curves) *run.add_curves() = std::move(curve);
  }
  return result;
}

std::optional<v1::Prediction> Studies::predict(const v1::PredictStudyRequest& request) {
  const auto record = store_.find(request.id());
  if (!record) return std::nullopt;
  const RunCounts counts = store_.counts(record->id);
  const bool running = counts.ended() < counts.all();
  return predictions_.predict(*record, counts.of(v1::SUCCEEDED), running, request,
                              [&] { return evaluated_runs(*record, {.histories = true}); });
}

void Studies::ready_surface(const std::string& id) {
  const auto record = store_.find(id);
  if (!record || !record->request.has_sweep() ||
      record->request.sweep().design() == v1::SweepPlan::ENDS)
    return;
  const RunCounts counts = store_.counts(id);
  const bool running = counts.ended() < counts.all();
  predictions_.prepare(*record, counts.of(v1::SUCCEEDED), running,
                       [&] { return evaluated_runs(*record, {.histories = true}); });
}

}  // namespace dccast::studies
