#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/statistics/trajectory_forecast.hpp"
#include "server/studies/executed_levers.hpp"

namespace dccast::studies {

/// A curl that was measured.
struct CurlReading {
  double time_s;
  double curl_m;
};

/// A gauge whose scale or sign is wrong, as readings show that no casting of the plan has.
struct WrongGauge {
  double time_s = 0.0;                     ///< of the reading that shows it
  double shown_m = 0.0, expected_m = 0.0;  ///< there; expected before the casting
  std::string mistake{};                   ///< that explains it
};

/// Finds the mistake of scale or sign of a gauge, judged by what was expected before the casting.
/// Each reading alone would be believed: it is as near to the one before as those of a sound gauge.
///
/// Of the last ten readings eight have to be unlikely, and of all readings since the curl is to be
/// seen nine of ten to be explained by one mistake. Without the latter a casting whose curl falls
/// back would be taken for a gauge that shows a tenth.
/// @param instants  of the plan [s]
std::optional<WrongGauge> find_wrong_gauge(const statistics::TrajectoryForecast& before,
                                           const Eigen::VectorXd& instants,
                                           const ExecutedLevers& levers,
                                           const std::vector<CurlReading>& readings);

}  // namespace dccast::studies
