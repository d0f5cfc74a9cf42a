#include "core/casting/findings/shell.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <utility>
#include <vector>

#include "core/mesh/cell_shape.hpp"

namespace dccast::casting {

namespace {

constexpr double unreached = std::numeric_limits<double>::infinity();

/// Elements around each node, contiguous by node.
class ElementsOfNodes {
public:
  template <int Dim>
  explicit ElementsOfNodes(const mesh::Mesh<Dim>& mesh)
      : first_(std::size_t(mesh.nodes()) + 1, 0), element_(mesh.element_node.size()) {
    for (int n : mesh.element_node) ++first_[std::size_t(n) + 1];
    for (std::size_t n = 1; n < first_.size(); ++n) first_[n] += first_[n - 1];

    std::vector<int> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < element_.size(); ++i) {
      const std::size_t n = std::size_t(mesh.element_node[i]);
      element_[std::size_t(next[n]++)] = static_cast<int>(i) / mesh.nodes_per_element;
    }
  }
  std::span<const int> at_node(int n) const {
    const auto begin = std::size_t(first_[std::size_t(n)]);
    return {element_.data() + begin, std::size_t(first_[std::size_t(n) + 1]) - begin};
  }

private:
  std::vector<int> first_;
  std::vector<int> element_;
};

template <int Dim>
std::span<const int> corners(const mesh::Mesh<Dim>& mesh, int e) {
  return {mesh.nodes_of(e), std::size_t(mesh.nodes_per_element)};
}

/// (node) not zero at the top of the slab, and in the melt that is connected to it.
template <int Dim>
std::vector<char> find_open_melt(const mesh::Mesh<Dim>& mesh, std::span<const char> solid,
                                 const ElementsOfNodes& around) {
  double level = -unreached;
  for (int n = 0; n < mesh.nodes(); ++n) level = std::max(level, mesh.point(n)[Dim - 1]);
  constexpr double same_height = 1e-9;  // [m]

  std::vector<char> reached(std::size_t(mesh.nodes()), 0);
  std::vector<int> pending;
  const auto reach = [&](int n) {
    if (reached[std::size_t(n)] != 0) return;
    reached[std::size_t(n)] = 1;
    pending.push_back(n);
  };

  for (int n = 0; n < mesh.nodes(); ++n)
    if (mesh.point(n)[Dim - 1] >= level - same_height) reach(n);

  // Depth-first through the liquid elements.
  while (!pending.empty()) {
    const int n = pending.back();
    pending.pop_back();
    for (int e : around.at_node(n)) {
      if (solid[std::size_t(e)] != 0) continue;
      for (int neighbour : corners(mesh, e)) reach(neighbour);
    }
  }
  return reached;
}

template <int Dim>
double distance(const mesh::Mesh<Dim>& mesh, int a, int b) {
  const double *from = mesh.point(a), *to = mesh.point(b);
  if constexpr (Dim == 2)
    return std::hypot(to[0] - from[0], to[1] - from[1]);
  else
    return std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
}

/// The end of a path.
struct Tip {
  double length;
  int node;
  int begin;  ///< bottom node at which the path begins
  bool operator>(const Tip& other) const { return length > other.length; }
};

/// (node) height above the block [m], also over its bowl: above the node of the bottom below it. In
/// an imported mesh, whose nodes need not stand above each other, above the height 0.
template <int Dim>
std::vector<double> heights_above_block(const mesh::Mesh<Dim>& mesh) {
  using Place = std::array<double, Dim - 1>;
  const auto place = [&](int n) {
    Place at{};
    std::copy_n(mesh.point(n), Dim - 1, at.begin());
    return at;
  };

  std::map<Place, double> block;
  for (const int n : mesh::patch_nodes(mesh, mesh::PatchKind::bottom))
    block[place(n)] = mesh.point(n)[Dim - 1];

  std::vector<double> height;
  for (int n = 0; n < mesh.nodes(); ++n) {
    const auto below = block.find(place(n));
    height.push_back(mesh.point(n)[Dim - 1] - (below == block.end() ? 0.0 : below->second));
  }
  return height;
}

/// Smallest value of a nodal field in an element.
template <int Dim>
double lowest_of(const mesh::Mesh<Dim>& mesh, int e, std::span<const double> field) {
  double lowest = unreached;
  for (const int n : corners(mesh, e)) lowest = std::min(lowest, field[std::size_t(n)]);
  return lowest;
}

/// The point where an edge between a cold and a hot node crosses the isotherm.
template <int Dim>
std::array<double, Dim> crossing(const double* cold, const double* hot, double share) {
  std::array<double, Dim> point{};
  for (std::size_t d = 0; d < Dim; ++d) point[d] = cold[d] + share * (hot[d] - cold[d]);
  return point;
}

}  // namespace

/// Dijkstra's algorithm: edges of liquid elements have length zero.
template <int Dim>
std::optional<PlacedFigure> thinnest_shell(const mesh::Mesh<Dim>& mesh,
                                           std::span<const char> solid) {
  const ElementsOfNodes around(mesh);
  const std::vector<char> melt = find_open_melt(mesh, solid, around);

  std::vector<double> shortest(std::size_t(mesh.nodes()), unreached);
  std::priority_queue<Tip, std::vector<Tip>, std::greater<>> tips;
  const auto extend_to = [&](int n, double length, int begin) {
    if (length >= shortest[std::size_t(n)]) return;
    shortest[std::size_t(n)] = length;
    tips.push({length, n, begin});
  };

  for (int n : mesh::patch_nodes(mesh, mesh::PatchKind::bottom)) extend_to(n, 0.0, n);

  while (!tips.empty()) {
    const Tip tip = tips.top();
    tips.pop();
    if (melt[std::size_t(tip.node)] != 0) {
      const double* begin = mesh.point(tip.begin);
      return PlacedFigure{tip.length, {begin, begin + Dim}};
    }
    if (tip.length > shortest[std::size_t(tip.node)]) continue;  // a shorter path came later

    for (int e : around.at_node(tip.node)) {
      const bool liquid = solid[std::size_t(e)] == 0;
      for (int n : corners(mesh, e))
        extend_to(n, tip.length + (liquid ? 0.0 : distance(mesh, tip.node, n)), tip.begin);
    }
  }
  return std::nullopt;
}

template <int Dim>
bool melt_touches_bottom(const mesh::Mesh<Dim>& mesh, std::span<const char> solid) {
  std::vector<char> at_bottom(std::size_t(mesh.nodes()), 0);
  for (int n : mesh::patch_nodes(mesh, mesh::PatchKind::bottom)) at_bottom[std::size_t(n)] = 1;

  for (int e = 0; e < mesh.elements(); ++e) {
    if (solid[std::size_t(e)] != 0) continue;
    for (int n : corners(mesh, e))
      if (at_bottom[std::size_t(n)] != 0) return true;
  }
  return false;
}

template <int Dim>
Located<Dim> bottom_shell(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                          double isotherm) {
  const std::vector<double> height = heights_above_block(mesh);
  Located<Dim> lowest{mesh.largest(Dim - 1), {}};
  const auto consider = [&](int cold, int hot, double share) {
    const double from = height[std::size_t(cold)], to = height[std::size_t(hot)];
    const double above = from + share * (to - from);
    if (above >= lowest.value) return;
    lowest = {above, crossing<Dim>(mesh.point(cold), mesh.point(hot), share)};
    lowest.place[Dim - 1] -= above;
  };

  const auto& edges = mesh::cell_shape(Dim, mesh.nodes_per_element).edges;
  for (int e = 0; e < mesh.elements(); ++e) {
    if (lowest_of(mesh, e, height) >= lowest.value) continue;  // skips most elements
    for (const auto& [i, j] : edges) {
      int cold = mesh.nodes_of(e)[i], hot = mesh.nodes_of(e)[j];
      if (temperature[std::size_t(cold)] > temperature[std::size_t(hot)]) std::swap(cold, hot);
      const double low = temperature[std::size_t(cold)], high = temperature[std::size_t(hot)];
      if (high < isotherm) continue;

      // Where the whole edge is hot, both of its ends count.
      consider(cold, hot, low >= isotherm ? 0.0 : (isotherm - low) / (high - low));
      if (low >= isotherm) consider(cold, hot, 1.0);
    }
  }
  return lowest;
}

template std::optional<PlacedFigure> thinnest_shell(const mesh::Mesh<2>&, std::span<const char>);
template std::optional<PlacedFigure> thinnest_shell(const mesh::Mesh<3>&, std::span<const char>);
template bool melt_touches_bottom(const mesh::Mesh<2>&, std::span<const char>);
template bool melt_touches_bottom(const mesh::Mesh<3>&, std::span<const char>);
template Located<2> bottom_shell(const mesh::Mesh<2>&, std::span<const double>, double);
template Located<3> bottom_shell(const mesh::Mesh<3>&, std::span<const double>, double);

}  // namespace dccast::casting
