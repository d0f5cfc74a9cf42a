#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace dccast::linalg {

/// Sparsity pattern of a symmetric matrix: lower triangle in compressed columns, and for each
/// element the index of each of its entries, so that assembly is one addition per entry.
///
/// Built once per mesh and extended as the mesh grows. The caller keeps the values in a plain
/// vector of `entries()` numbers.
///
/// Units: in this room matrix entries, right-hand sides and solutions have the units of the caller.
class SparsityPattern {
public:
  /// The pattern of an empty matrix.
  SparsityPattern() = default;
  /// @param unknowns          size of the matrix
  /// @param element_unknown   (element, per_element) unknowns coupled by each element; negative
  ///                          ones do not take part
  SparsityPattern(int unknowns, std::span<const int> element_unknown, int per_element);

  /// Extends the pattern after growth of the mesh: columns from the lowest unknown of a new element
  /// on are rebuilt, those before it are kept. The result equals a pattern built from all elements.
  /// @param element_unknown  of all elements, the old ones first
  void extend(int unknowns, std::span<const int> element_unknown);

  /// Size of the matrix, and entries of its lower triangle.
  int unknowns() const { return static_cast<int>(column_start_.size()) - 1; }
  std::size_t entries() const { return row_.size(); }
  /// 3 or 2 where the unknowns 3 n, 3 n + 1, 3 n + 2 (or 2 n, 2 n + 1) have the same neighbours for
  /// every n, as the displacements of a node have; else 1.
  int unknowns_per_node() const { return unknowns_per_node_; }
  /// (unknown + 1) index of the first entry of each column, which is its diagonal.
  const std::vector<int>& column_start() const { return column_start_; }
  /// (entry) row, ascending within a column.
  const std::vector<int>& row() const { return row_; }
  /// First columns of the parts of a matrix-vector product, and the end of the last part. Two even
  /// parts never write to the same row, nor do two odd ones, so that all even parts can run
  /// concurrently, then all odd ones. There is one part only if the matrix is small, has a large
  /// bandwidth, or does not have three unknowns per node.
  const std::vector<int>& parts() const { return part_; }
  /// Index of the diagonal entry of an unknown.
  int diagonal(int unknown) const { return column_start_[std::size_t(unknown)]; }
  /// Indices of an element's entries, (per_element, per_element) full and symmetric; -1 where an
  /// unknown does not take part. An off-diagonal pair has one index: add it once, for j <= i.
  const int* places(int element) const {
    return place_.data() +
           std::size_t(element) * std::size_t(per_element_) * std::size_t(per_element_);
  }

private:
  /// Whether from column `first` on the unknowns come in whole nodes with the same neighbours.
  bool is_made_of_nodes(int unknowns_per_node, int first) const;
  /// Sets the number of unknowns per node: 3, 2 or 1.
  void find_unknowns_per_node(int first);
  /// Divides the columns for the product; see parts().
  void find_parts();
  /// Whether no two even parts, and no two odd ones, write to the same row.
  bool is_divided_by(const std::vector<int>& part) const;

  int per_element_ = 0;
  int unknowns_per_node_ = 1;
  std::vector<int> column_start_{0};
  std::vector<int> row_;
  std::vector<int> place_;
  std::vector<int> part_{0, 0};
};

/// y = A x for a symmetric matrix given by its lower triangle. With three unknowns per node it
/// works node by node and divides the work among the team lent to the calling thread; the bits do
/// not depend on the size of the team.
void multiply(const SparsityPattern& pattern, std::span<const double> values,
              std::span<const double> x, std::span<double> y);

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
    const auto add = [&](int node, int other) {
      neighbour_[std::size_t(next[std::size_t(node)]++)] = other;
    };
    // Lower numbers first: columns come in ascending order, and each is added to the lists of its
    // rows.
    for_each_pair(pattern, [&](int a, int b) { add(b, a); });
    for_each_pair(pattern, [&](int a, int b) { add(a, b); });
  }

  /// Numbers of nodes, and of unknowns of each.
  int nodes() const { return nodes_; }
  int unknowns_per_node() const { return per_node_; }
  /// Neighbours of a node in ascending order, without the node itself.
  std::span<const int> neighbours(int node) const {
    const std::size_t first = std::size_t(start_[std::size_t(node)]);
    return {neighbour_.data() + first, std::size_t(start_[std::size_t(node) + 1]) - first};
  }

  /// Visits all nodes level by level of distance from a front, and within a level in the order of
  /// the neighbours in the level before; then, as fronts of their own, the nodes that are connected
  /// to nothing.
  struct Sweep {
    std::vector<int> order;     ///< nodes
    std::vector<int> distance;  ///< (node) [1] steps from neighbour to neighbour
  };
  /// @param front  unknowns
  Sweep sweep_from(std::span<const int> front) const;

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

/// Order of elimination that sweeps a mesh from one of its edges (Cuthill-McKee): level by level of
/// distance in the graph of the matrix, and within a level in the order of the neighbours in the
/// level before. On a mesh in rows the bandwidth is then that of a row or a column of nodes.
/// @param front  unknowns of the edge, in their order along it
/// @return       (unknown) its position
std::vector<int> sweep_order(const SparsityPattern& pattern, std::span<const int> front);

/// The reversed numbering: (unknown) its position.
std::vector<int> reversed_order(int unknowns);

}  // namespace dccast::linalg
