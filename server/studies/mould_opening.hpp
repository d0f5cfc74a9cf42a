#pragma once

#include <array>
#include <vector>

namespace dccast::studies {

/// Half the opening of a mould along the wide face, from its middle to the narrow face: three
/// straight segments, the first one flat (paper, figure 3). It never widens outwards and narrows
/// ever more steeply, so that the mould is convex.
struct MouldOpening {
  std::array<double, 4> x{};     ///< [m] 0, the two break points, half the length of the face
  std::array<double, 4> half{};  ///< [m] half-opening there

  double at(double place) const;  ///< [m]
  bool operator==(const MouldOpening&) const = default;
};

/// What an opening must keep to.
struct OpeningBounds {
  double length = 0.0;  ///< [m] half the length of the wide face
  double spacing =
      0.0;             ///< [m] least length of a segment, so that the mesh has a row of nodes each
  double least = 0.0;  ///< [m] of the half-openings
  double most = 0.0;   ///< [m]
};

/// The opening nearest to some half-openings in least squares, over its break points and heights;
/// break points are whole millimetres, heights hundredths of one.
/// @param x     [m] rising, 0 to the length  @param half  [m] as long as x
/// @pre         three segments of the spacing fit into the length
MouldOpening nearest_opening(const std::vector<double>& x, const std::vector<double>& half,
                             const OpeningBounds& bounds);

}  // namespace dccast::studies
