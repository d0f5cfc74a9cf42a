#pragma once

#include <filesystem>
#include <optional>

namespace dccast::mesh {

enum class SectionKind { plane_strain, axisymmetric };
enum class ElementKind { p1, q1, q1_bending };

/// The section of the slab and how it is divided; tables `section` and `mesh` of a case.
struct SectionSpec {
  SectionKind kind = SectionKind::plane_strain;
  double half_width = 0.0;     ///< [m]
  double initial_depth = 0.0;  ///< [m]
  ElementKind element = ElementKind::q1_bending;
  int columns = 30;
  int rows = 22;
  double side_cell = 3e-3;              ///< [m]
  double bottom_cell = 3e-3;            ///< [m]
  std::optional<double> growth_cell;    ///< [m]; absent: height of the topmost initial row
  int refinement = 1;
  std::filesystem::path file;           ///< Gmsh mesh; empty: the built-in one
  bool growth = true;
};

}  // namespace dccast::mesh
