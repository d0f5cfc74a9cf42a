#pragma once

#include <optional>
#include <vector>

namespace dccast::client {

/// What a sequence of figures on meshes of halved cells and steps says of its limit.
struct Extrapolation {
  std::optional<double> order;  ///< observed; nothing where the sequence does not settle
  double value = 0.0;           ///< Richardson's limit; the last figure where there is no order
  double uncertainty = 0.0;     ///< half width of the interval around `value`
};

/// Extrapolates from the last three figures, each with half the cell and step of the one before.
///
/// With differences d1, d2 of one sign and |d2| < |d1| the observed order is log2(d1/d2), and the
/// limit lies d2 / (2^p - 1) beyond the last figure; for the limit p is kept between 1/2 and 2, the
/// orders of the methods. The uncertainty is 1.25 times the distance from the last figure to the
/// limit, Roache's factor for three meshes. A sequence that swings or drifts has no limit to offer:
/// then the uncertainty is the largest difference seen.
/// @param figures  coarsest first, at least two
Extrapolation extrapolate(const std::vector<double>& figures);

}  // namespace dccast::client
