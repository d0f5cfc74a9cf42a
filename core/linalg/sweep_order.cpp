#include "core/linalg/sweep_order.hpp"

#include <cstddef>

#include "core/linalg/node_graph.hpp"

namespace dccast::linalg {

std::vector<int> sweep_order(const SparsityPattern& pattern, std::span<const int> front) {
  const NodeGraph graph(pattern, pattern.unknowns_per_node());
  std::vector<int> order, place_of_node(std::size_t(graph.nodes()), -1);
  order.reserve(place_of_node.size());
  const auto take = [&](int node) {
    if (place_of_node[std::size_t(node)] >= 0) return;
    place_of_node[std::size_t(node)] = static_cast<int>(order.size());
    order.push_back(node);
  };
  const int per_node = graph.unknowns_per_node();
  for (const int unknown : front) take(unknown / per_node);
  std::size_t next = 0;
  const auto sweep = [&] {
    for (; next < order.size(); ++next) {
      for (const int neighbour : graph.neighbours(order[next])) take(neighbour);
    }
  };
  sweep();
  for (int node = 0; node < graph.nodes(); ++node) {  // what is joined to nothing yet
    take(node);
    sweep();
  }
  std::vector<int> place(std::size_t(pattern.unknowns()));
  for (int u = 0; u < pattern.unknowns(); ++u)
    place[std::size_t(u)] = place_of_node[std::size_t(u / per_node)] * per_node + u % per_node;
  return place;
}

std::vector<int> reversed_order(int unknowns) {
  std::vector<int> place(std::size_t(unknowns), 0);
  for (int u = 0; u < unknowns; ++u) place[std::size_t(u)] = unknowns - 1 - u;
  return place;
}

}  // namespace dccast::linalg
