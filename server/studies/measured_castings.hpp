#pragma once

#include <vector>

#include "server/studies/study_plan.hpp"

namespace dccast::studies {

/// A casting that was measured, with the runs of its case.
struct MeasuredCasting {
  v1::CreateStudyRequest request;  ///< of a Latin hypercube with measured curves
  std::vector<EvaluatedRun> runs;  ///< of it and of all further studies, with histories
  int last = 0;                    ///< how many of them the last further study has
};

/// The axes inferred from the measured curves (docs/calibration.md). The same runs give the same.
/// @throws CannotPredict  too few valid runs, axes that differ, no reading within the computed time
v1::Calibration calibration_of(std::vector<MeasuredCasting> castings);

}  // namespace dccast::studies
