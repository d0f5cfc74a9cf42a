#pragma once

#include <optional>

#include "server/studies/sweep_surfaces.hpp"

namespace dccast::studies {

/// Results of studies: their runs, and what their plans conclude from them. Safe to use from
/// several threads.
class StudyEvaluation {
public:
  /// All outlive this object.
  StudyEvaluation(StudiesState& state, RunResults& results, SweepSurfaces& surfaces)
      : state_(state), results_(results), surfaces_(surfaces) {}

  /// Current results of a study; empty if there is no such study.
  std::optional<v1::StudyResult> evaluate(const v1::EvaluateStudyRequest& request);

private:
  /// Calibrates with the runs of all castings. The runs of a casting come from its first study, and
  /// from further ones that check it. @throws CannotPredict
  v1::Calibration calibration(const v1::EvaluateStudyRequest& request);

  StudiesState& state_;
  RunResults& results_;
  SweepSurfaces& surfaces_;
};

}  // namespace dccast::studies
