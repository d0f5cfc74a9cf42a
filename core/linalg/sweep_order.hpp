#pragma once

#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// Order of elimination that sweeps a mesh from one of its edges: level by level of distance in the
/// graph of the matrix, the neighbours of one unknown after those of the one before
/// (CuthillMcKee). On a mesh in rows the band is then as wide as a row or a column of nodes.
/// @param front  unknowns of the edge, in their order along it
/// @return (unknown) its place
std::vector<int> sweep_order(const SparsityPattern& pattern, std::span<const int> front);

/// The order of the numbering, backwards: (unknown) its place.
std::vector<int> reversed_order(int unknowns);

}  // namespace dccast::linalg
