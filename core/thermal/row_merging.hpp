#pragma once

#include <span>
#include <vector>

#include "core/mesh/row_merging.hpp"

namespace dccast::thermal {

/// Carries nodal enthalpies over to a mesh of which rows were merged, so that no heat is lost or
/// made: a node that is taken out leaves its enthalpy to its neighbours below and above, in the
/// shares in which they gain its volume. The values stay between those of the neighbours.
///
/// @param volume_before  (node before) [m^Dim]
/// @param volume_after   (node after) [m^Dim]
/// @param enthalpy       (node) [J/m3], of the mesh before on entry, after on return
void merge_enthalpy(const mesh::MergedRows& merged, std::span<const double> volume_before,
                    std::span<const double> volume_after, std::vector<double>& enthalpy);

/// Sum of volume times enthalpy [J]. @param enthalpy  (node) [J/m3]
double heat_content(std::span<const double> volume, std::span<const double> enthalpy);

}  // namespace dccast::thermal
