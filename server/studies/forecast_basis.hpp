#pragma once

#include <memory>
#include <stdexcept>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/follow.pb.h"
#include "dccast/v1/job.pb.h"
#include "dccast/v1/line.pb.h"
#include "dccast/v1/study.pb.h"

namespace dccast::studies {

/// There is no forecast yet; the text is the reason.
class CannotForecast : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Runs of an ensemble that a forecast needs at least: bands of fewer hold too seldom.
inline constexpr int fewest_members = 16;

/// A casting that has ended on the line, with the studies of its plan.
struct EarlierCasting {
  v1::LineCasting casting;
  /// With curves; null: the study is not there any more. Without pairs theirs has no runs.
  std::shared_ptr<const v1::StudyResult> ensemble, pairs;
};

/// What a forecast rests on. Of the studies, which are given with curves, runs count that succeeded
/// and stayed valid.
struct ForecastBasis {
  const v1::StudyResult& ensemble;
  /// At a finer quality, over the same keys: runs whose values are those of a run of the ensemble.
  /// Without runs there are no pairs.
  const v1::StudyResult& pairs;
  const v1::Case& plan;  ///< complete
  const v1::Following& following;
  const std::vector<v1::Reading>& readings;
  /// Curls of the run of the plan, on which a forecast without an ensemble rests.
  std::vector<v1::CurlCurve> plan_run{};
  /// Curls of the run that follows the casting, where the run of the plan has its mesh and data.
  /// They tell what levers that left the plan have done (executed_levers.hpp); empty: the forecast
  /// takes the levers as planned.
  std::vector<v1::CurlCurve> followed_run{};
  double error_of_plan = 0.25;  ///< [1] as error_of_plan()
  /// On the line of the casting, the oldest first.
  std::vector<EarlierCasting> earlier{};
  /// Levers moved from some times on, on which the advice rests (advice.hpp); null: none.
  std::shared_ptr<const v1::StudyResult> levers{};
};

}  // namespace dccast::studies
