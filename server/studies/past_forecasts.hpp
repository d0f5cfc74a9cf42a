#pragma once

#include <vector>

#include "dccast/v1/line.pb.h"
#include "server/judging/followed_casting.hpp"
#include "server/studies/forecast_basis.hpp"

namespace dccast::studies {

/// What each gauge was expected to show 30 and 60 s ahead, at each of its readings and from those
/// before alone. Forecasts begin with the start of the block. A slip of the gauge is known from the
/// reading that shows it on: forecasts from before then for times after the slip are left out.
/// @throws CannotForecast
std::vector<judging::PastForecast> past_forecasts(const ForecastBasis& basis);

/// Curls that an ended casting leaves to the next ones on its line: at each gauge at a dozen
/// times, the median of the readings around each, less what levers that left the plan have done.
/// Readings that a forecast leaves out do not count, nor those after a gauge has slipped.
/// @throws CannotForecast
std::vector<v1::ObservedCurl> observed_curls(const ForecastBasis& basis);

}  // namespace dccast::studies
