#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>

#include "core/base/curve.hpp"
#include "core/mesh/row_merging.hpp"

namespace dccast::mesh {

/// Plane strain through the thickness of a wide slab, a billet, or a quarter of a slab.
enum class SectionKind { plane_strain, axisymmetric, quarter_slab };
/// Linear triangles or tetrahedra, B-bar quadrilaterals or hexahedra, and these with bending modes:
/// docs/developers/decisions.md.
enum class ElementKind { p1, q1, q1_bending };

/// Number of coordinates of a section.
constexpr int dimension_of(SectionKind kind) {
  return kind == SectionKind::quarter_slab ? 3 : 2;
}

/// The name of a kind in results and case files, e.g. "plane_strain".
constexpr const char* name_of(SectionKind kind) {
  constexpr const char* names[] = {"plane_strain", "axisymmetric", "quarter_slab"};
  return names[static_cast<int>(kind)];
}

/// The cells of the heat in a column and in a layer of a quarter slab. With one of each, heat and
/// mechanics have the same mesh.
struct HeatCells {
  int per_column = 1;
  int per_layer = 1;
};

/// A bowl in the bottom block, which the first metal fills: flat in the middle, with a wall that
/// rises to a flat lip along the edge of the block.
struct Bowl {
  double depth = 0.0;  ///< [m] of its middle below the lip
  double lip = 0.0;    ///< [m] width of the lip
  double wall = 0.0;   ///< [m] width of the wall, from the lip to the middle

  /// Depth below the lip [m]. The wall is half a wave of a cosine: it joins lip and middle without
  /// a kink.
  /// @param inward  [m] distance from the edge of the block
  double depth_at(double inward) const {
    const double share = std::clamp((inward - lip) / wall, 0.0, 1.0);
    return 0.5 * depth * (1.0 - std::cos(std::numbers::pi * share));
  }
};

/// The simulated part of the slab and its mesh; tables `section` and `mesh` of a case. Columns are
/// cells from the symmetry plane (x = 0) to the side, in a quarter slab to its narrow face; layers
/// are cells from y = 0 to the wide face. They are those of the mechanics; the heat may divide
/// them.
struct SectionSpec {
  SectionKind kind = SectionKind::plane_strain;
  double half_width = 0.0;  ///< [m]; for a quarter slab half the length of its wide face
  /// [m] quarter slab only, against distance from x = 0: half the opening of the mould in y,
  /// piecewise linear. A constant is a rectangle; values above that at the end make the mould
  /// convex.
  Curve half_thickness;
  double corner_radius = 0.0;  ///< [m] quarter slab only; 0 is a square corner
  double initial_depth = 0.0;  ///< [m] over the block's lip
  std::optional<Bowl> bowl;    ///< absent: the block is flat
  ElementKind element = ElementKind::p1;
  /// Cells before refinement.
  int columns = 0;
  int layers = 0;
  int rows = 0;
  HeatCells heat_cells;               ///< quarter slab of hexahedra only
  double side_cell = 0.0;             ///< [m] width of the column at the side
  double wide_side_cell = 0.0;        ///< [m] width of the layer at the wide face, at x = 0
  double bottom_cell = 0.0;           ///< [m] height of the lowest row
  std::optional<double> growth_cell;  ///< [m]; absent: height of the topmost initial row
  RowMerging merging;  ///< quarter slab of hexahedra only; largest_cell is before refinement
  int refinement = 1;
  std::filesystem::path file;  ///< Gmsh mesh; empty: the built-in one
  bool growth = false;
};

}  // namespace dccast::mesh
