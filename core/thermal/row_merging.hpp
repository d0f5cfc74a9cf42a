#pragma once

#include <span>
#include <vector>

#include "core/mesh/row_merging.hpp"

namespace dccast::thermal {

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
