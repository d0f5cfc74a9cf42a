#pragma once

#include <array>
#include <vector>

#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// The rounded corner between narrow and wide face of a quarter slab: an arc tangent to the narrow
/// face x = half_width and to the last straight piece of the opening.
struct CornerArc {
  using Point = std::array<double, 2>;

  double radius = 0.0;  ///< [m]
  Point centre{};       ///< [m]
  double angle = 0.0;   ///< [rad] from the normal of the narrow face to that of the wide face

  /// A point of the arc. @param at  [rad] from the normal of the narrow face
  Point point(double at) const;
  Point on_narrow_face() const { return point(0.0); }
  Point on_wide_face() const { return point(angle); }
};

/// The arc of a section with a corner radius. @pre its opening is given at the half width
CornerArc corner_arc(const SectionSpec& spec);

/// A grid of points of a plan, columns along x and layers along y; (column, layer, 2) [m].
struct PlanGrid {
  int columns = 0;  ///< of points
  int layers = 0;
  std::vector<double> place;  ///< (column, layer, 2) [m]

  /// The two coordinates of a point [m].
  double* at(int column, int layer) {
    return place.data() + 2 * (std::size_t(column) * std::size_t(layers) + std::size_t(layer));
  }
  /// The two coordinates of a point [m].
  const double* at(int column, int layer) const {
    return const_cast<PlanGrid*>(this)->at(column, layer);
  }
};

/// Position of the arc in a grid: the column at its end on the wide face, the layer at its end on
/// the narrow face.
struct CornerPatch {
  int column = 0;
  int layer = 0;
};

/// Moves the points of the corner patch: those on its two outer sides to the arc, at equal angles
/// on half the arc each; those inside by transfinite interpolation between its four sides.
void round_corner(const CornerArc& arc, const CornerPatch& patch, PlanGrid& grid);

/// Smallest number of cells of a corner along each face. With two, neighbouring chords differ by
/// less than 30 degrees, so that the mould holds each node along one normal.
inline constexpr int fewest_corner_cells = 2;

}  // namespace dccast::mesh
