#pragma once

#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// Order of elimination that sweeps a mesh from one of its edges (Cuthill-McKee): level by level of
/// distance in the graph of the matrix, and within a level in the order of the neighbours in the
/// level before. On a mesh in rows the bandwidth is then that of a row or a column of nodes.
/// @param front  unknowns of the edge, in their order along it
/// @return       (unknown) its position
std::vector<int> sweep_order(const SparsityPattern& pattern, std::span<const int> front);

/// The reversed numbering: (unknown) its position.
std::vector<int> reversed_order(int unknowns);

}  // namespace dccast::linalg
