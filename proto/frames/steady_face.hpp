#pragma once

#include <vector>

#include "proto/frames/contraction.hpp"

namespace dccast::frames {

/// The wide face of a quarter slab where its casting is steady, away from butt and head.
///
/// The pull-in of a row is final once the row lies below the sump. So the face is read at nine
/// tenths of the height up to which the slab is solid all through; what the rows from three
/// quarters of it on still differ by says how steady the casting is there.
struct SteadyFace {
  double height_m = 0.0;        ///< above the bottom block, in the undeformed slab
  double change_m = 0.0;        ///< most that the cold half-thickness differs between those rows
  std::vector<double> x_m;      ///< from the middle of the face outwards
  std::vector<double> mould_m;  ///< half the opening of the mould, by x
  std::vector<double> cold_m;   ///< half-thickness at 20 °C, by x

  /// The largest distance from a flat face of this half-thickness [m].
  double residual_m(double wanted_m) const;
};

/// @throws NoContraction  the slab is not solid high enough above its butt: the run is too short
SteadyFace steady_face(const Contraction& contraction);

}  // namespace dccast::frames
