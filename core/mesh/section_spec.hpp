#pragma once

#include <filesystem>
#include <optional>

#include "core/base/curve.hpp"
#include "core/mesh/row_merging.hpp"

namespace dccast::mesh {

/// Plane strain through the thickness of a wide slab, a billet, or a quarter of a slab.
enum class SectionKind { plane_strain, axisymmetric, quarter_slab };
/// Linear triangles or tetrahedra, B-bar quadrilaterals or hexahedra, and these with bending modes:
/// docs/developers/elements.md.
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
  double initial_depth = 0.0;  ///< [m]
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
