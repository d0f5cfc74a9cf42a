#pragma once

#include <optional>
#include <vector>

#include "core/statistics/sobol_indices.hpp"
#include "dccast/v1/study.pb.h"

namespace dccast::studies {

/// Curls that are accepted [m].
struct CurlBand {
  double least = 0.0, greatest = 0.0;
};

/// The curl of one monitor as a function of inputs that are uniform in (0, 1).
struct SampledCurls {
  statistics::SampledFunction curls;  ///< (place, input) -> (place, instant) [m]
  std::vector<double> time_s, cast_length_m;
  std::vector<double> error_m;  ///< by instant: root mean square of what `curls` is off
};

/// What the inputs leave open: the 5, 50 and 95 % curl at every instant, with the error of the
/// function as normal noise, and the shares of the inputs in the variance of the curl at some
/// instants; the last share is that of the error. The same whenever the function is.
v1::Spread spread_of(const SampledCurls& sampled, int inputs, const std::optional<CurlBand>& band);

}  // namespace dccast::studies
