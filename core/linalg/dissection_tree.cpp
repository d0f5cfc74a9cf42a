#include "core/linalg/dissection_tree.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

namespace {

/// A part with fewer unknowns is one front: its columns fill the tiles.
constexpr int leaf_unknowns = 48;

/// Halves the nodes until they are leaves.
class Dissection {
public:
  Dissection(const NodeGraph& graph, std::span<const std::vector<int>> edges, DissectionTree& tree)
      : tree_(tree), leaf_(std::max(1, leaf_unknowns / graph.unknowns_per_node())) {
    for (std::size_t a = 0; a < axes; ++a) distance_[a] = graph.sweep_from(edges[a]).distance;

    order_.resize(std::size_t(graph.nodes()));
    for (std::size_t n = 0; n < order_.size(); ++n) order_[n] = static_cast<int>(n);
    divide(0, graph.nodes(), 0);

    tree_.place.resize(order_.size());
    for (std::size_t p = 0; p < order_.size(); ++p)
      tree_.place[std::size_t(order_[p])] = static_cast<int>(p);
  }

private:
  static constexpr std::size_t axes = 2;
  using Iterator = std::vector<int>::iterator;

  /// A line of nodes: those at this distance along an axis.
  struct Line {
    std::size_t axis;
    int distance;
  };

  int distance(std::size_t axis, int node) const { return distance_[axis][std::size_t(node)]; }

  /// Divides a part of the order recursively. @return the number of its front
  int divide(int first, int end, int depth) {
    if (end - first <= leaf_) return add({first, end, depth, {}, {}});
    const Line line = find_middle(first, end);
    if (line.distance < 0) return add({first, end, depth, {}, {}});

    // Nodes before the line, then those behind it, then those on it.
    const auto begin = order_.begin() + first, to = order_.begin() + end;
    const auto before = [&](int n) { return distance(line.axis, n) < line.distance; };
    const auto behind = [&](int n) { return distance(line.axis, n) > line.distance; };
    const auto second = std::stable_partition(begin, to, before);
    const auto on_line = std::stable_partition(second, to, behind);

    const int half = static_cast<int>(second - order_.begin());
    const int own = static_cast<int>(on_line - order_.begin());
    const int left = divide(first, half, depth + 1);
    const int right = divide(half, own, depth + 1);
    return add({own, end, depth, {left, right}, {}});
  }

  int add(DissectionTree::Front front) {
    tree_.fronts.push_back(std::move(front));
    return static_cast<int>(tree_.fronts.size()) - 1;
  }

  /// The line across the longer direction that gives halves of equal size; its distance is -1 if no
  /// line separates the nodes.
  Line find_middle(int first, int end) {
    std::size_t axis = 0;
    std::array<int, axes> low, high;
    for (std::size_t a = 0; a < axes; ++a) {
      const auto [least, most] =
          std::minmax_element(order_.begin() + first, order_.begin() + end,
                              [&](int m, int n) { return distance(a, m) < distance(a, n); });
      low[a] = distance(a, *least);
      high[a] = distance(a, *most);
      if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
    }
    if (high[axis] - low[axis] < 2) return {axis, -1};

    // Histogram of the distances, and its median, which must leave nodes on both sides.
    count_.assign(std::size_t(high[axis] - low[axis]) + 1, 0);
    for (int p = first; p < end; ++p)
      ++count_[std::size_t(distance(axis, order_[std::size_t(p)]) - low[axis])];

    int below = 0, distance = low[axis];
    while (2 * (below + count_[std::size_t(distance - low[axis])]) < end - first) {
      below += count_[std::size_t(distance - low[axis])];
      ++distance;
    }
    return {axis, std::clamp(distance, low[axis] + 1, high[axis] - 1)};
  }

  DissectionTree& tree_;
  int leaf_;
  std::array<std::vector<int>, axes> distance_;
  std::vector<int> order_;  ///< (place) node
  std::vector<int> count_;
};

/// The nodes coupled by the elimination of a front: its later neighbours, and the boundaries of its
/// children.
void find_boundaries(const NodeGraph& graph, DissectionTree& tree) {
  std::vector<int> node_at(tree.place.size()), last_front(tree.place.size(), -1);
  for (std::size_t n = 0; n < tree.place.size(); ++n)
    node_at[std::size_t(tree.place[n])] = static_cast<int>(n);

  // Children come before their parents, so that their boundaries are known.
  for (std::size_t f = 0; f < tree.fronts.size(); ++f) {
    auto& front = tree.fronts[f];
    const auto add = [&](int place) {
      int& added_to = last_front[std::size_t(place)];
      if (place < front.end || added_to == static_cast<int>(f)) return;
      added_to = static_cast<int>(f);
      front.boundary.push_back(place);
    };

    for (int p = front.first; p < front.end; ++p) {
      for (const int n : graph.neighbours(node_at[std::size_t(p)])) add(tree.place[std::size_t(n)]);
    }
    for (const int child : front.children) {
      for (const int p : tree.fronts[std::size_t(child)].boundary) add(p);
    }
    std::sort(front.boundary.begin(), front.boundary.end());
  }
}

}  // namespace

DissectionTree::DissectionTree(const SparsityPattern& pattern,
                               std::span<const std::vector<int>> edges)
    : unknowns_per_node(pattern.unknowns_per_node() == 2 ? 2 : 1) {
  const NodeGraph graph(pattern, unknowns_per_node);
  Dissection(graph, edges, *this);
  find_boundaries(graph, *this);
}

double DissectionTree::flops() const {
  double sum = 0.0;
  for (const Front& front : fronts) {
    const double own = double(front.end - front.first) * unknowns_per_node;
    const double rest = double(front.boundary.size()) * unknowns_per_node;
    sum += own * (own * own / 3.0 + rest * (own + rest));
  }
  return sum;
}

}  // namespace dccast::linalg
