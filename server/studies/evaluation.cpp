// Results of studies: runs with their figures and curves, and the conclusions of a plan from them.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <optional>

#include "proto/case_file/quality.hpp"
#include "proto/figures/run_history.hpp"
#include "proto/values/interpolation.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/studies/measured_castings.hpp"
#include "server/studies/studies.hpp"

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

/// @param wanted_m  half-thickness of the cold slab
void describe_face(const RunFace& cast, double wanted_m, v1::MouldFace& face) {
  const v1::Curve& opening = cast.section.half_thickness_m();
  *face.mutable_break_point_m() = opening.at();
  *face.mutable_half_opening_m() = opening.value();

  const frames::SteadyFace& steady = cast.steady;
  face.set_height_m(steady.height_m);
  face.set_change_m(steady.change_m);
  face.mutable_x_m()->Assign(steady.x_m.begin(), steady.x_m.end());
  face.mutable_half_mould_m()->Assign(steady.mould_m.begin(), steady.mould_m.end());
  face.mutable_half_thickness_m()->Assign(steady.cold_m.begin(), steady.cold_m.end());
  face.set_residual_m(steady.residual_m(wanted_m));
}

void describe_without_job(const RunRecord& record, v1::StudyRun& run) {
  run.set_state(record.to_queue() ? v1::QUEUED : record.outcome);
  if (record.outcome == v1::FAILED) *run.mutable_failure() = record.failure;
}

/// Memory of a history [bytes].
std::size_t bytes_of(const RunCurves& history) {
  std::size_t bytes = 0;
  for (const v1::CurlCurve& curve : history.curves) bytes += curve.SpaceUsedLong();
  for (const auto& [monitor, temperature_c] : history.temperature_c)
    bytes += temperature_c.size() * sizeof(double);
  return bytes + history.least_shell_m.size() * sizeof(double);
}

/// @throws jobs::UnsoundResult  the job has none
const v1::Artifact& results_of(const v1::Job& job) {
  const auto found = std::ranges::find(job.artifacts(), "results.h5", &v1::Artifact::name);
  if (found != job.artifacts().end()) return *found;
  throw jobs::UnsoundResult("job " + job.id() + " has no results.h5; run it again");
}

}  // namespace

const v1::CurlCurve* RunCurves::curve(const std::string& monitor) const {
  const auto found = std::ranges::find(curves, monitor, &v1::CurlCurve::monitor);
  return found == curves.end() ? nullptr : &*found;
}

std::vector<double> at_instants(const std::vector<double>& instants_s, const v1::CurlCurve& curve,
                                const google::protobuf::RepeatedField<double>& figures) {
  return values::at_instants(instants_s, {curve.time_s().begin(), curve.time_s().end()},
                             {figures.begin(), figures.end()});
}

RunCurves run_curves(const v1::Job& job, std::vector<v1::StepReport> steps) {
  const figures::RunHistory history = figures::run_history(job, std::move(steps));
  const std::vector<double> time_s = history.time_s(), cast_length_m = history.cast_length_m();

  RunCurves curves;
  curves.beyond_from_s = history.beyond_from_s();
  for (const v1::StepReport& step : history.steps)
    curves.least_shell_m.push_back(step.least_shell_m());

  for (const std::string& monitor : history.monitors()) {
    figures::MonitorSeries series = history.series(monitor);
    v1::CurlCurve& curve = curves.curves.emplace_back();
    curve.set_monitor(monitor);
    curve.mutable_time_s()->Add(time_s.begin(), time_s.end());
    curve.mutable_cast_length_m()->Add(cast_length_m.begin(), cast_length_m.end());
    curve.mutable_curl_m()->Add(series.curl_m.begin(), series.curl_m.end());

    const auto is_known = [](double temperature_c) { return std::isfinite(temperature_c); };
    if (std::ranges::any_of(series.temperature_c, is_known))
      curves.temperature_c[monitor] = std::move(series.temperature_c);
  }
  return curves;
}

RunCurves Studies::history_of(const v1::Job& job) {
  if (const auto kept = histories_.find(job.id())) return *kept;

  const auto log = scheduler_.log(job.id());
  auto page = jobs::StepIndex().page(*log, {}, SIZE_MAX, SIZE_MAX);
  const auto history = std::make_shared<const RunCurves>(
      page ? run_curves(job, std::move(page->steps)) : RunCurves{});

  // Only the history of an ended job cannot change any more.
  if (jobs::is_terminal(job.state())) histories_.keep(job.id(), history, bytes_of(*history));
  return *history;
}

/// Contour of the wide face of a run, from its last frame; kept after the first call.
/// @throws jobs::WorkerDidNotAnswer, jobs::UnsoundResult, frames::NoContraction
std::shared_ptr<const RunFace> Studies::face_of(const v1::Job& job) {
  if (const auto kept = faces_.find(job.id())) return kept;

  v1::Case complete;
  if (!jobs::read_complete_case(options_.jobs_directory / job.id(), complete))
    throw jobs::WorkerDidNotAnswer(jobs::WorkerDidNotAnswer::Why::refused,
                                   "the case of job " + job.id() + " cannot be read");

  const auto last =
      intake_.stored_frame(options_.jobs_directory / job.id(), results_of(job), {},
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
  } catch (const jobs::UnsoundResult& unsound) {
    run.face_fault = unsound.what();
  } catch (const jobs::WorkerDidNotAnswer& error) {
    // Without a worker nothing is known of the face: the call can be repeated.
    if (error.why() == jobs::WorkerDidNotAnswer::Why::not_started) throw;
    run.face_fault = error.what();
  }
}

/// Runs of a study with as much of their results as `depth` asks for. Runs of deleted jobs are
/// omitted.
std::vector<EvaluatedRun> Studies::evaluated_runs(const StudyRecord& record, const Depth& depth) {
  const auto plan = plan_of(record);
  std::vector<EvaluatedRun> runs;

  for (const RunAndJob& each : runs_and_jobs(record)) {
    const auto& [kept, job] = each;
    if (kept.number >= depth.before) break;
    if (each.deleted()) continue;

    EvaluatedRun& evaluated = runs.emplace_back();
    evaluated.number = kept.number;
    plan->describe(kept.number, evaluated.run);

    if (job)
      describe_job(*job, evaluated.run);
    else
      describe_without_job(kept, evaluated.run);

    for (const v1::Monitor& monitor : record.request.case_().monitor())
      evaluated.run.add_end_curl_m(evaluated.succeeded() ? figures::curl_of(figures::monitor_of(
                                                               job->last_step(), monitor.name()))
                                                         : NAN);

    if (!evaluated.succeeded()) continue;
    if (depth.histories) evaluated.history = history_of(*job);
    if (depth.faces) add_face(*job, evaluated);
  }
  return runs;
}

SweepState Studies::sweep_state(const StudyRecord& record) {
  using Runs = std::vector<EvaluatedRun>;
  const RunCounts counts = store_.counts(record.id);
  return {record, counts.of(v1::SUCCEEDED), counts.ended() < counts.all(),
          [this, &record, read = std::optional<Runs>()]() mutable -> const Runs& {
            if (!read) read = evaluated_runs(record, {.histories = true});
            return *read;
          }};
}

/// Calibrates with the runs of all castings. The runs of a casting come from its first study, and
/// from further ones that check it. @throws CannotPredict
v1::Calibration Studies::calibration(const v1::EvaluateStudyRequest& request) {
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
  return calibration_of(std::move(castings));
}

std::optional<v1::StudyResult> Studies::evaluate(const v1::EvaluateStudyRequest& request) {
  const auto record = store_.find(request.id());
  if (!record) return std::nullopt;

  const bool curves = request.curves();
  const auto plan = plan_of(*record);
  auto runs = evaluated_runs(
      *record, {.histories = curves || plan->needs_histories(), .faces = plan->needs_faces()});

  v1::StudyResult result;
  *result.mutable_study() = view(*record);
  for (const v1::Monitor& monitor : record->request.case_().monitor())
    result.add_monitors(monitor.name());
  plan->evaluate(runs, result);

  // A part that cannot be computed yet leaves its reason: the others stand.
  try {
    if (!request.spread().empty())
      *result.mutable_spread() = predictions_.spread(sweep_state(*record), request.spread());
  } catch (const CannotPredict& reason) {
    result.set_spread_fault(reason.what());
  }
  try {
    if (!request.castings().empty()) *result.mutable_calibration() = calibration(request);
  } catch (const CannotPredict& reason) {
    result.set_calibration_fault(reason.what());
  }

  for (EvaluatedRun& evaluated : runs) {
    v1::StudyRun& run = *result.add_runs() = std::move(evaluated.run);
    if (evaluated.face)
      describe_face(*evaluated.face, result.mould().wanted_half_thickness_m(), *run.mutable_face());
    run.set_face_fault(evaluated.face_fault);
    case_file::set_end_errors(run.end_curl_m(), run);
    if (curves)
      for (v1::CurlCurve& curve : evaluated.history.curves) *run.add_curves() = std::move(curve);
  }
  return result;
}

std::optional<v1::Prediction> Studies::predict(const v1::PredictStudyRequest& request) {
  const auto record = store_.find(request.id());
  if (!record) return std::nullopt;
  return predictions_.predict(sweep_state(*record), request);
}

void Studies::ready_surface(const std::string& id) {
  const auto record = store_.find(id);
  if (record && record->request.has_sweep() &&
      record->request.sweep().design() != v1::SweepPlan::ENDS)
    predictions_.prepare(sweep_state(*record));
}

}  // namespace dccast::studies
