#include "core/linalg/sweep_order.hpp"

#include <cstddef>

namespace dccast::linalg {

namespace {

/// Neighbours of every unknown, in the order of their numbers.
struct Graph {
  std::vector<int> start, neighbour;

  explicit Graph(const SparsityPattern& pattern) {
    const std::size_t size = std::size_t(pattern.unknowns());
    start.assign(size + 1, 0);
    for_each_pair(pattern, [&](int c, int r) {
      ++start[std::size_t(c) + 1];
      ++start[std::size_t(r) + 1];
    });
    for (std::size_t u = 0; u < size; ++u) start[u + 1] += start[u];
    neighbour.resize(2 * (pattern.entries() - size));
    std::vector<int> next(start.begin(), start.end() - 1);
    // Lower numbers first: the columns come in rising order, each names itself to its rows.
    for_each_pair(pattern,
                  [&](int c, int r) { neighbour[std::size_t(next[std::size_t(r)]++)] = c; });
    for_each_pair(pattern,
                  [&](int c, int r) { neighbour[std::size_t(next[std::size_t(c)]++)] = r; });
  }

  template <class Use>
  static void for_each_pair(const SparsityPattern& pattern, const Use& use) {
    for (int c = 0; c < pattern.unknowns(); ++c) {
      const int end = pattern.column_start()[std::size_t(c) + 1];
      for (int k = pattern.diagonal(c) + 1; k < end; ++k) use(c, pattern.row()[std::size_t(k)]);
    }
  }
};

}  // namespace

std::vector<int> sweep_order(const SparsityPattern& pattern, std::span<const int> front) {
  const Graph graph(pattern);
  const std::size_t size = std::size_t(pattern.unknowns());
  std::vector<int> order, place(size, -1);
  order.reserve(size);
  const auto take = [&](int unknown) {
    if (place[std::size_t(unknown)] >= 0) return;
    place[std::size_t(unknown)] = static_cast<int>(order.size());
    order.push_back(unknown);
  };
  for (const int unknown : front) take(unknown);
  std::size_t next = 0;
  const auto sweep = [&] {
    for (; next < order.size(); ++next) {
      const std::size_t u = std::size_t(order[next]);
      for (int k = graph.start[u]; k < graph.start[u + 1]; ++k) {
        take(graph.neighbour[std::size_t(k)]);
      }
    }
  };
  sweep();
  for (int unknown = 0; unknown < pattern.unknowns(); ++unknown) {  // what is joined to nothing yet
    take(unknown);
    sweep();
  }
  return place;
}

std::vector<int> reversed_order(int unknowns) {
  std::vector<int> place(std::size_t(unknowns), 0);
  for (int u = 0; u < unknowns; ++u) place[std::size_t(u)] = unknowns - 1 - u;
  return place;
}

}  // namespace dccast::linalg
