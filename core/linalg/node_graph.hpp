#pragma once

#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// Neighbours of every node of a matrix, in the order of their numbers.
class NodeGraph {
public:
  /// @param per_node  number of unknowns per node: that of the pattern, or 1
  NodeGraph(const SparsityPattern& pattern, int per_node)
      : per_node_(per_node), nodes_(pattern.unknowns() / per_node_) {
    start_.assign(std::size_t(nodes_) + 1, 0);
    for_each_pair(pattern, [this](int a, int b) {
      ++start_[std::size_t(a) + 1];
      ++start_[std::size_t(b) + 1];
    });
    for (std::size_t n = 0; n < std::size_t(nodes_); ++n) start_[n + 1] += start_[n];
    neighbour_.resize(std::size_t(start_.back()));
    std::vector<int> next(start_.begin(), start_.end() - 1);
    const auto add = [&](int of, int other) {
      neighbour_[std::size_t(next[std::size_t(of)]++)] = other;
    };
    // Lower numbers first: columns come in ascending order, and each is added to the lists of its
    // rows.
    for_each_pair(pattern, [&](int a, int b) { add(b, a); });
    for_each_pair(pattern, [&](int a, int b) { add(a, b); });
  }

  int nodes() const { return nodes_; }
  int unknowns_per_node() const { return per_node_; }
  std::span<const int> neighbours(int node) const {
    const std::size_t first = std::size_t(start_[std::size_t(node)]);
    return {neighbour_.data() + first, std::size_t(start_[std::size_t(node) + 1]) - first};
  }

private:
  /// Calls use(a, b) for all neighbours a < b.
  template <class Use>
  void for_each_pair(const SparsityPattern& pattern, const Use& use) const {
    for (int a = 0; a < nodes_; ++a) {
      const int column = a * per_node_, end = pattern.column_start()[std::size_t(column) + 1];
      for (int k = pattern.diagonal(column) + per_node_; k < end; k += per_node_)
        use(a, pattern.row()[std::size_t(k)] / per_node_);
    }
  }

  int per_node_, nodes_;
  std::vector<int> start_, neighbour_;
};

}  // namespace dccast::linalg
