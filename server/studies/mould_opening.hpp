#pragma once

#include <array>
#include <optional>
#include <vector>

#include "proto/frames/contraction.hpp"

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

/// Constraints on an opening.
struct OpeningBounds {
  double length = 0.0;  ///< [m] half the length of the wide face
  double spacing =
      0.0;             ///< [m] least length of a segment, so that the mesh has a row of nodes each
  double least = 0.0;  ///< [m] of the half-openings
  double most = 0.0;   ///< [m]
};

/// Opening nearest to some half-openings in least squares. Break points are whole millimetres,
/// heights whole hundredths of a millimetre.
/// @param x     [m] rising, 0 to the length  @param half  [m] as long as x
/// @pre         three segments of the spacing fit into the length
MouldOpening nearest_opening(const std::vector<double>& x, const std::vector<double>& half,
                             const OpeningBounds& bounds);

/// Wanted flat slab.
struct MouldTarget {
  double wanted = 0.0;     ///< [m] half-thickness of the cold slab
  double tolerance = 0.0;  ///< [m] of it, anywhere along the face
  OpeningBounds bounds{};
};

/// The trial whose cold slab is nearest to the wanted one; null without trials.
const frames::SteadyFace* best_trial(const std::vector<frames::SteadyFace>& history, double wanted);

/// The opening to try next: that of the best trial, enlarged everywhere by what its cold slab
/// lacks, as mould makers correct a mould, and fitted with three segments.
///
/// The slab is at first assumed to follow a change of the opening completely. From two trials on,
/// the share s of a change that contraction takes up is fitted to all changes between successive
/// trials (least squares over the face), and the correction is divided by 1 - s: a secant method in
/// one unknown.
///
/// @return  empty if the search is finished: a trial is within the tolerance, or three segments
///          promise no slab whose residual is a tenth smaller
std::optional<MouldOpening> next_opening(const std::vector<frames::SteadyFace>& history,
                                         const MouldTarget& target);

}  // namespace dccast::studies
