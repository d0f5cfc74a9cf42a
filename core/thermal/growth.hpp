#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/row_merging.hpp"

namespace dccast::thermal {

/// Heat of a slab before metal entered, and heat brought in by the metal.
struct MetalEntry {
  double stored_before = 0.0;  ///< [J/m]; axisymmetric: per radian [J/rad]; solid: [J]
  double entered = 0.0;        ///< [J/m], [J/rad], [J]
  double superheat = 0.0;      ///< [J/m], [J/rad], [J] part of it above the liquidus
};

/// Nodal data of a mesh of rows that has grown (mesh::SlabMesh::grow_to).
struct GrownRows {
  /// Nodes of one row of the built-in mesh.
  std::size_t nodes_per_row;
  std::span<const double> volume_before;  ///< (old node) [m^Dim], axisymmetric: [m3/rad]
  /// (old node) with the old top row stretched to the new level [m^Dim], [m3/rad]; the same as
  /// volume_after if no row was inserted.
  std::span<const double> volume_stretched;
  std::span<const double> volume_after;  ///< (node) [m^Dim], [m3/rad]
  /// [m] of the rows of nodes, starting with the one below the old top
  std::span<const double> height;
};

/// Transfers nodal enthalpies to a mesh that has grown and conserves heat exactly: the sum of
/// volume times enthalpy increases by exactly the heat of the metal that entered.
///
/// First the old top row is stretched to the new level: the volume that its nodes gain is filled
/// with entering metal. Then, if rows were inserted, it is divided: the new nodes receive the
/// volume, with its enthalpy, that their neighbours in the column lose. On rectangles and bricks
/// this is linear interpolation, and the result never leaves the range of the neighbours.
///
/// @param entering_enthalpy  [J/m3] of the metal poured
/// @param enthalpy           (node) [J/m3], of the mesh before on entry, after on return
MetalEntry carry_enthalpy(const GrownRows& rows, double entering_enthalpy,
                          std::vector<double>& enthalpy);

/// Transfers nodal enthalpies to a mesh with merged rows and conserves heat: the enthalpy of a
/// removed node goes to its neighbours below and above, in the proportion in which they gain its
/// volume. The new values stay within the range of the neighbours.
///
/// @param volume_before  (node before) [m^Dim]
/// @param volume_after   (node after) [m^Dim]
/// @param enthalpy       (node) [J/m3], on the old mesh on entry, on the new one on return
void merge_enthalpy(const mesh::MergedRows& merged, std::span<const double> volume_before,
                    std::span<const double> volume_after, std::vector<double>& enthalpy);

/// Sum of volume times enthalpy [J].
/// @param volume    (node) [m3]
/// @param enthalpy  (node) [J/m3]
double heat_content(std::span<const double> volume, std::span<const double> enthalpy);

}  // namespace dccast::thermal
