#pragma once

#include <utility>

#include "core/mesh/section_spec.hpp"

namespace dccast::testing {

/// The metal of a quarter slab at the start.
struct QuarterBlock {
  double half_width;     ///< [m] along x
  Curve half_thickness;  ///< [m] in y against x
  double depth;          ///< [m]
};

/// Its numbers of cells along x, y and z, and the widths of the cells at the faces.
struct QuarterCells {
  int columns, layers, rows;
  double side, wide_side, bottom;  ///< [m]
};

/// A section of a quarter slab with the built-in mesh.
inline mesh::SectionSpec quarter_section(mesh::ElementKind element, QuarterBlock block,
                                         const QuarterCells& cells) {
  mesh::SectionSpec spec;
  spec.kind = mesh::SectionKind::quarter_slab;
  spec.element = element;

  spec.half_width = block.half_width;
  spec.half_thickness = std::move(block.half_thickness);
  spec.initial_depth = block.depth;

  spec.columns = cells.columns;
  spec.layers = cells.layers;
  spec.rows = cells.rows;
  spec.side_cell = cells.side;
  spec.wide_side_cell = cells.wide_side;
  spec.bottom_cell = cells.bottom;
  return spec;
}

}  // namespace dccast::testing
