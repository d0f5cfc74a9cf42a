// The case on successively refined meshes with shorter steps, and the limit of its curl.
#include <algorithm>
#include <optional>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "server/intake/case_intake.hpp"
#include "server/studies/extrapolation.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

namespace {

constexpr int fewest_levels = 2, most_levels = 5;

/// Limit of one monitor's curl at the instants of the coarsest run; empty with fewer than two runs.
std::optional<v1::StudyResult::Limit> limit_of(const std::vector<const EvaluatedRun*>& levels,
                                               const v1::CurlCurve& coarsest) {
  const std::vector<double> time_s(coarsest.time_s().begin(), coarsest.time_s().end());

  std::vector<RefinedCurve> curves;
  for (const EvaluatedRun* level : levels)
    if (const v1::CurlCurve* curve = level->history.curve(coarsest.monitor()))
      curves.push_back({level->run.refinement(), at_instants(time_s, *curve, curve->curl_m())});
  if (curves.size() < 2) return std::nullopt;

  const CurveLimit found = extrapolate(time_s, curves);
  v1::StudyResult::Limit limit;
  *limit.mutable_curve() = coarsest;
  limit.mutable_curve()->mutable_curl_m()->Assign(found.value_m.begin(), found.value_m.end());
  limit.mutable_curve()->mutable_uncertainty_m()->Assign(found.uncertainty_m.begin(),
                                                         found.uncertainty_m.end());

  if (found.order) limit.set_order(*found.order);
  return limit;
}

class RefinementStudy final : public StudyPlan {
public:
  explicit RefinementStudy(const v1::CreateStudyRequest& request)
      : base_(request.case_()), levels_(request.refinement().levels()) {
    case_file::apply_quality(base_);  // before the defaults, which would hide what it leaves open
    case_file::apply_defaults(*base_.mutable_mesh());
  }

  int runs() const override { return levels_; }

  PlannedRun run(int number) const override {
    return {key(number), "refinement " + key(number), case_file::divided(base_, 1 << number), {}};
  }
  std::string key(int number) const override { return std::to_string(refinement(number)); }

  void describe(int number, v1::StudyRun& run) const override {
    run.set_refinement(refinement(number));
  }

  bool needs_histories() const override { return true; }

  void evaluate(const std::vector<EvaluatedRun>& runs, v1::StudyResult& result) const override {
    std::vector<const EvaluatedRun*> levels;
    for (const EvaluatedRun& run : runs) {
      if (!run.succeeded() || run.history.curves.empty()) continue;
      levels.push_back(&run);
      if (const auto& from_s = run.history.beyond_from_s)
        if (!result.has_valid_until_s() || *from_s < result.valid_until_s())
          result.set_valid_until_s(*from_s);
    }
    if (levels.size() < 2) return;
    for (const v1::CurlCurve& curve : levels.front()->history.curves)
      if (auto limit = limit_of(levels, curve)) *result.add_limits() = std::move(*limit);
  }

private:
  int refinement(int number) const { return base_.mesh().refinement() * (1 << number); }

  v1::Case base_;
  int levels_;
};

}  // namespace

std::vector<v1::Fault> refinement_faults(const v1::CreateStudyRequest& request) {
  std::vector<v1::Fault> faults;
  const int levels = request.refinement().levels();
  if (levels < fewest_levels || levels > most_levels)
    faults.push_back(
        intake::fault_of("refinement.levels", std::to_string(levels), "is out of range", "2 to 5"));
  if (const std::string reason = case_file::reason_against_dividing(request.case_());
      !reason.empty())
    faults.push_back(intake::fault_of("refinement", "", reason));
  return faults;
}

std::unique_ptr<StudyPlan> refinement_plan(const v1::CreateStudyRequest& request) {
  return std::make_unique<RefinementStudy>(request);
}

}  // namespace dccast::studies
