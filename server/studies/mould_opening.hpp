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

/// The flat slab that is wanted.
struct MouldTarget {
  double wanted = 0.0;     ///< [m] half-thickness of the cold slab
  double tolerance = 0.0;  ///< [m] of it, anywhere along the face
  OpeningBounds bounds{};
};

/// The trial, a mould that was cast in and its cold slab, whose slab is nearest to what is wanted;
/// null without trials.
const frames::SteadyFace* best_trial(const std::vector<frames::SteadyFace>& history, double wanted);

/// The opening to cast in next, as mould makers correct one: that of the best trial, and what its
/// cold slab lacks everywhere, brought back to three segments.
///
/// How much of a change of the opening the slab follows is not known at first and taken as all of
/// it. With two trials or more, the share s of a change that contraction eats is fitted to all
/// changes between trials in a row (least squares over the face), and the correction divided by
/// 1 - s: the secant of the one unknown that matters.
///
/// @return  nothing when the search is over: a trial is within the tolerance, or three segments
///          promise no slab that is nearer to flat by a tenth
std::optional<MouldOpening> next_opening(const std::vector<frames::SteadyFace>& history,
                                         const MouldTarget& target);

}  // namespace dccast::studies
