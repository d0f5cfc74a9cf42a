#pragma once

#include <vector>

#include "proto/frames/contraction.hpp"

namespace dccast::frames {

/// The wide face of a quarter slab where the casting is steady, away from butt and head.
///
/// The pull-in of a row is final once the row is below the sump. The face is therefore evaluated at
/// nine tenths of the height up to which the slab is completely solid; the differences between the
/// rows above three quarters of this height show how steady the casting is there.
struct SteadyFace {
  double height_m = 0.0;    ///< above the bottom block, in the undeformed slab [m]
  double change_m = 0.0;    ///< largest difference of cold half-thickness between those rows [m]
  std::vector<double> x_m;  ///< from the middle of the face outwards [m]
  std::vector<double> mould_m;  ///< (x) half the opening of the mould [m]
  std::vector<double> cold_m;   ///< (x) half-thickness at 20 °C [m]

  /// Largest deviation from a flat face of this half-thickness [m]. @param wanted_m  [m]
  double residual_m(double wanted_m) const;
};

/// @throws NoContraction  the solid part above the butt is not high enough: the run is too short
SteadyFace steady_face(const Contraction& contraction);

}  // namespace dccast::frames
