#pragma once

#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::thermal {

/// Heat of a slab before metal was poured onto it, and heat that came with the metal.
struct MetalEntry {
  double stored_before = 0.0;  ///< [J/m]; axisymmetric: per radian [J/rad]
  double entered = 0.0;        ///< [J/m], [J/rad]
};

/// Carries nodal enthalpies over to a slab mesh that has grown (mesh::SlabMesh2D::grow_to), so that
/// no heat is lost or made: the sum of volume times enthalpy rises by exactly the metal that
/// entered.
///
/// First the old top row stretches to the new level: what its nodes gain in volume is filled with
/// entering metal. Then, where rows were put in, it is divided: the new nodes take over what their
/// neighbours in the column lose in volume, which is linear interpolation on rectangles and never
/// leaves the range of the neighbours.
///
/// @param before             mesh the enthalpy belongs to
/// @param after              mesh of the same columns with as many or more rows
/// @param nodes_per_row      nodes in a row of the structured mesh
/// @param entering_enthalpy  [J/m3] of the metal poured
/// @param enthalpy           (node) [J/m3], of `before` on entry, of `after` on return
MetalEntry carry_enthalpy(const mesh::Mesh2D& before, const mesh::Mesh2D& after, int nodes_per_row,
                          mesh::SectionKind kind, double entering_enthalpy,
                          std::vector<double>& enthalpy);

}  // namespace dccast::thermal
