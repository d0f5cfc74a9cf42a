#pragma once

#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// An order of elimination by nested dissection (George 1973), and the fronts of a multifrontal
/// factorisation in it. Entities of the tree are nodes: the unknowns of a node have the same
/// neighbours.
///
/// The mesh is halved again and again. What halves it are the nodes at one distance from an edge of
/// the mesh, in steps from element to element: neighbours are at most one step apart, so that such
/// a line separates any mesh, and on a grid it is a line of the grid.
struct DissectionTree {
  /// Nodes that are eliminated together, and those that their elimination couples.
  struct Front {
    int first = 0, end = 0;     ///< places of its own nodes in the order
    int depth = 0;              ///< cuts above it
    std::vector<int> children;  ///< fronts, all before this one
    std::vector<int> boundary;  ///< places of later nodes, ascending
  };

  std::vector<int> place;  ///< (node) its place in the order
  std::vector<Front>
      fronts;  ///< children before parents; what is left of a child lies in its parent
  int unknowns_per_node = 1;  ///< 2 or 1, so that rows of tiles have whole nodes

  /// @param edges  two sets of unknowns along edges of the mesh from which distances count
  DissectionTree(const SparsityPattern& pattern, std::span<const std::vector<int>> edges);

  /// Multiplications and additions of a factorisation [1].
  double flops() const;
};

}  // namespace dccast::linalg
