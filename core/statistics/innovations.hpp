#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/curve.hpp"
#include "core/statistics/trajectory_forecast.hpp"

namespace dccast::statistics {

/// A reading and what was expected of it. Units are those of the quantity.
struct Innovation {
  double time = 0.0;  ///< [s]
  double reading = 0.0;
  double first_mean = 0.0;  ///< expected before anything was measured
  Estimated expected;       ///< from the readings before, noise and zero included
};

/// A reading farther from what was expected is an outlier [standard deviations].
inline constexpr double farthest_innovation = 4.0;

/// Reading minus expectation, in standard deviations.
double normalised(const Innovation& innovation);

/// By what factor innovations of sound castings may exceed what a Gaussian prior permits, against
/// the quantity that is expected [unit]; one or more. The members of an ensemble are sound
/// castings, yet not always Gaussian: each begins to curl at its own time, and a few are then far
/// from what the others permit. Once the curl is there, nothing of this is left, at whatever time.
///
/// Each sixth of the members is forecast from the others. The largest statistic of find_departures
/// that a member reaches near a value, within two standard deviations of a reading, and two of what
/// noise adds to it, must stay below the limit. Readings come every second.
/// @throws std::invalid_argument  as prior_of, of five sixths of the members
Curve member_scale(const TrajectoryEnsemble& ensemble, const Gauge& gauge);

/// How readings leave what prior and earlier readings permit.
struct Departure {
  enum class Kind {
    step,  ///< from one reading to the next
    drift
  };
  Kind kind = Kind::drift;
  double time = 0.0;   ///< [s] of the reading that shows it
  double begin = 0.0;  ///< [s] of the first reading after the step, or of the drift's average
  double size = 0.0;   ///< height of the step, or mean of reading minus expectation [unit]
};

/// Finds where readings leave what was expected.
///
/// Normalised innovations of a correct prior are independent, with mean 0 and variance 1 (Mehra and
/// Peschon 1971). A departure begins where their sum over 10 s exceeds 4.2 times the root of their
/// number, or where four outliers follow each other; it ends at half of that sum. An outlier counts
/// as one of four standard deviations, so that no single one is a departure. Innovations are
/// divided by the scale at the expected reading first.
///
/// A step is told from a drift by least squares over 20 s before and 10 s after: readings minus
/// their first mean are a straight line and either a step or a bend, whichever leaves less. It is a
/// step where the bend leaves more by nine times the variance of a reading.
/// @param innovations  by time
/// @param noise        standard deviation of a reading [unit]
std::vector<Departure> find_departures(const std::vector<Innovation>& innovations, double noise,
                                       const Curve& scale = Curve(1.0));

}  // namespace dccast::statistics
