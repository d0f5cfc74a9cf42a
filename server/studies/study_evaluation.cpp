#include "server/studies/study_evaluation.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

#include "proto/case_file/quality.hpp"
#include "server/studies/measured_castings.hpp"
#include "server/studies/study_view.hpp"

namespace dccast::studies {

namespace {

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

/// Moves the runs, with their faces and curves, into the answer.
void add_runs(const v1::Case& description, std::vector<EvaluatedRun>&& runs, bool curves,
              v1::StudyResult& result) {
  for (EvaluatedRun& evaluated : runs) {
    v1::StudyRun& run = *result.add_runs() = std::move(evaluated.run);
    if (evaluated.face)
      describe_face(*evaluated.face, result.mould().wanted_half_thickness_m(), *run.mutable_face());
    run.set_face_fault(evaluated.face_fault);
    case_file::set_end_errors(description, run.end_curl_m(), run);
    if (curves)
      for (v1::CurlCurve& curve : evaluated.history.curves) *run.add_curves() = std::move(curve);
  }
}

}  // namespace

v1::Calibration StudyEvaluation::calibration(const v1::EvaluateStudyRequest& request) {
  std::vector<MeasuredCasting> castings;

  for (const v1::CalibratedCasting& asked : request.castings()) {
    MeasuredCasting& casting = castings.emplace_back();
    for (const std::string& id : asked.studies()) {
      const auto study = state_.store.find(id);
      if (!study || !study->request.has_sweep()) throw CannotPredict("there is no sweep " + id);
      auto runs = results_.evaluated_runs(*study, {.histories = true});

      if (casting.runs.empty())
        casting.request = study->request;
      else
        casting.last = static_cast<int>(runs.size());
      std::ranges::move(runs, std::back_inserter(casting.runs));
    }
  }
  return calibration_of(std::move(castings));
}

std::optional<v1::StudyResult> StudyEvaluation::evaluate(const v1::EvaluateStudyRequest& request) {
  const auto study = state_.store.find(request.id());
  if (!study) return std::nullopt;

  const auto plan = state_.plan_of(*study);
  auto runs = results_.evaluated_runs(
      *study,
      {.histories = request.curves() || plan->needs_histories(), .faces = plan->needs_faces()});

  v1::StudyResult result;
  *result.mutable_study() = study_view(state_, *study);
  for (const v1::Monitor& monitor : study->request.case_().monitor())
    result.add_monitors(monitor.name());
  result.set_judged_monitor(study->request.case_().output().curl());
  plan->evaluate(runs, result);

  // A part that cannot be computed yet leaves its reason: the others stand.
  try {
    if (!request.spread().empty())
      *result.mutable_spread() = surfaces_.spread(*study, request.spread());
  } catch (const CannotPredict& reason) {
    result.set_spread_fault(reason.what());
  }
  try {
    if (!request.castings().empty()) *result.mutable_calibration() = calibration(request);
  } catch (const CannotPredict& reason) {
    result.set_calibration_fault(reason.what());
  }

  add_runs(study->request.case_(), std::move(runs), request.curves(), result);
  return result;
}

}  // namespace dccast::studies
