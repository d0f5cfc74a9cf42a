#pragma once

#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// An order of elimination by nested dissection (George 1973), and the fronts of a multifrontal
/// factorisation in this order. The tree is built on nodes: all unknowns of a node have the same
/// neighbours.
///
/// The mesh is bisected recursively. The separator is the set of nodes at one distance from an edge
/// of the mesh, counted in elements: neighbours differ in distance by at most one, so that such a
/// set separates any mesh; on a regular grid it is a grid line.
struct DissectionTree {
  /// Nodes that are eliminated together, and those that their elimination couples.
  struct Front {
    int first = 0, end = 0;     ///< positions of its own nodes in the order
    int depth = 0;              ///< number of separators above it
    std::vector<int> children;  ///< fronts, all before this one
    std::vector<int> boundary;  ///< positions of later nodes, ascending
  };

  std::vector<int> place;  ///< (node) its position in the order
  /// Children before parents; the boundary of a child lies in its parent
  std::vector<Front> fronts;
  int unknowns_per_node = 1;  ///< 2 or 1, so that rows of tiles have whole nodes

  /// @param edges  two sets of unknowns along edges of the mesh from which distances are counted
  DissectionTree(const SparsityPattern& pattern, std::span<const std::vector<int>> edges);

  /// Multiplications and additions of a factorisation [1].
  double flops() const;
};

}  // namespace dccast::linalg
