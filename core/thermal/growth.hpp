#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace dccast::thermal {

/// Heat of a slab before metal was poured onto it, and heat that came with the metal.
struct MetalEntry {
  double stored_before = 0.0;  ///< [J/m]; axisymmetric: per radian [J/rad]; solid: [J]
  double entered = 0.0;        ///< [J/m], [J/rad], [J]
};

/// A slab mesh of rows that has grown (mesh::ExtrudedMesh::grow_to), as its nodes see it.
struct GrownRows {
  std::size_t nodes_per_row;
  std::span<const double> volume_before;  ///< (old node) [m^Dim], axisymmetric: [m3/rad]
  /// (old node) with the old top row drawn up to the new level; where no row was put in, as after
  /// [m^Dim], [m3/rad].
  std::span<const double> volume_stretched;
  std::span<const double> volume_after;  ///< (node) [m^Dim], [m3/rad]
  std::span<const double> height;  ///< [m] of the rows of nodes, from the one below the old top
};

/// Carries nodal enthalpies over to a slab mesh that has grown, so that no heat is lost or made:
/// the sum of volume times enthalpy rises by exactly the metal that entered.
///
/// First the old top row stretches to the new level: what its nodes gain in volume is filled with
/// entering metal. Then, where rows were put in, it is divided: the new nodes take over what their
/// neighbours in the column lose in volume, which is linear interpolation on rectangles and bricks
/// and never leaves the range of the neighbours.
///
/// @param entering_enthalpy  [J/m3] of the metal poured
/// @param enthalpy           (node) [J/m3], of the mesh before on entry, after on return
MetalEntry carry_enthalpy(const GrownRows& rows, double entering_enthalpy,
                          std::vector<double>& enthalpy);

}  // namespace dccast::thermal
