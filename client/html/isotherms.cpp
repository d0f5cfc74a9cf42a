#include "client/html/isotherms.hpp"

namespace dccast::client::render {
namespace {

Point crossing(const Point& a, const Point& b, double value_a, double value_b, double level) {
  const double part = (level - value_a) / (value_b - value_a);
  return {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)};
}

}  // namespace

std::vector<std::array<int, 3>> triangles_of(const std::vector<int>& element_node,
                                             int nodes_per_element) {
  std::vector<std::array<int, 3>> triangles;
  if (nodes_per_element != 3 && nodes_per_element != 4) return triangles;
  const std::size_t count = element_node.size() / static_cast<std::size_t>(nodes_per_element);
  for (std::size_t e = 0; e < count; ++e) {
    const int* const node = element_node.data() + e * static_cast<std::size_t>(nodes_per_element);
    triangles.push_back({node[0], node[1], node[2]});
    if (nodes_per_element == 4) triangles.push_back({node[0], node[2], node[3]});
  }
  return triangles;
}

std::vector<Segment> isotherm(const std::vector<Point>& node, const std::vector<double>& value,
                              const std::vector<std::array<int, 3>>& triangles, double level) {
  std::vector<Segment> segments;
  for (const auto& triangle : triangles) {
    Segment segment;
    int found = 0;
    for (int i = 0; i < 3; ++i) {
      const int a = triangle[static_cast<std::size_t>(i)],
                b = triangle[static_cast<std::size_t>((i + 1) % 3)];
      if ((value[a] < level) == (value[b] < level)) continue;
      segment[static_cast<std::size_t>(found++)] =
          crossing(node[a], node[b], value[a], value[b], level);
    }
    if (found == 2) segments.push_back(segment);
  }
  return segments;
}

}  // namespace dccast::client::render
