#pragma once

#include "dccast/v1/follow.pb.h"
#include "server/studies/forecast_basis.hpp"

namespace dccast::studies {

/// Forecasts the curl at each gauge by conditioning its prior (curl_prior.hpp) on the curls
/// measured so far (core/statistics/trajectory_forecast.hpp). The error of the mesh moves the mean
/// and widens the band. A reading farther from what was expected than four standard deviations is
/// left out. Adds the findings that members have after the last reading, warnings where readings
/// leave what was expected (core/statistics/innovations.hpp), and notes. From a slip of a gauge on
/// its zero counts as unknown. @throws CannotForecast
v1::Forecast forecast_curls(const ForecastBasis& basis);

}  // namespace dccast::studies
