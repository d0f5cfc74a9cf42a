#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/statistics/trajectory_forecast.hpp"
#include "server/studies/forecast_basis.hpp"

namespace dccast::studies {

/// Half the width of a band that holds nine of ten, in standard deviations.
inline constexpr double nine_of_ten = 1.645;

/// Standard deviation of the curl of a plan due to its data, as a share of the whole curl, where
/// no ensemble gives it.
double error_of_plan(const v1::Section& section);

/// What is known of the curl at a gauge before its first reading.
struct CurlPrior {
  statistics::TrajectoryPrior trajectory{};  ///< [m]
  int members = 0;                           ///< 0: of the run of the plan alone
  /// The runs of the recipe, as they are without castings on the line; empty: of the run of the
  /// plan
  std::optional<statistics::TrajectoryEnsemble> ensemble{};
  std::optional<v1::LineMemory> line{};  ///< empty: the casting is on no line
  std::vector<std::string> notes{};      ///< why castings on the line do not count
};

/// The prior of the curl at a gauge: of the ensemble, its pairs and the castings on the line
/// (core/statistics/line_memory.hpp), or of the run of the plan. A casting on the line counts where
/// its ensemble has runs of the same data. @throws CannotForecast
CurlPrior prior_of_curl(const ForecastBasis& basis, const std::string& monitor);

}  // namespace dccast::studies
