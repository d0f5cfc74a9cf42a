#include "core/findings/shell.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

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
  std::span<const int> of(int n) const {
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

/// Nodes at the top of the slab and those of the melt below them (node).
template <int Dim>
std::vector<char> open_melt(const mesh::Mesh<Dim>& mesh, std::span<const char> solid,
                            const ElementsOfNodes& around) {
  double level = -unreached;
  for (int n = 0; n < mesh.nodes(); ++n) level = std::max(level, mesh.point(n)[Dim - 1]);
  constexpr double same_height = 1e-9;  // [m]
  std::vector<char> reached(std::size_t(mesh.nodes()), 0);
  std::vector<int> to_do;
  const auto reach = [&](int n) {
    if (reached[std::size_t(n)] != 0) return;
    reached[std::size_t(n)] = 1;
    to_do.push_back(n);
  };
  for (int n = 0; n < mesh.nodes(); ++n) {
    if (mesh.point(n)[Dim - 1] >= level - same_height) reach(n);
  }
  while (!to_do.empty()) {
    const int n = to_do.back();
    to_do.pop_back();
    for (int e : around.of(n)) {
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

/// A node reached by a path.
struct Tip {
  double length;
  int node;
  int begin;  ///< bottom node at which the path begins
  bool operator>(const Tip& other) const { return length > other.length; }
};

}  // namespace

/// Dijkstra's shortest path.
template <int Dim>
std::optional<Extreme> thinnest_shell(const mesh::Mesh<Dim>& mesh, std::span<const char> solid) {
  const ElementsOfNodes around(mesh);
  const std::vector<char> melt = open_melt(mesh, solid, around);
  std::vector<double> shortest(std::size_t(mesh.nodes()), unreached);
  std::priority_queue<Tip, std::vector<Tip>, std::greater<>> tips;
  const auto go_to = [&](int n, double length, int begin) {
    if (length >= shortest[std::size_t(n)]) return;
    shortest[std::size_t(n)] = length;
    tips.push({length, n, begin});
  };
  for (int n : mesh::patch_nodes(mesh, mesh::PatchKind::bottom)) go_to(n, 0.0, n);
  while (!tips.empty()) {
    const Tip tip = tips.top();
    tips.pop();
    if (melt[std::size_t(tip.node)] != 0) {
      const double* at = mesh.point(tip.begin);
      return Extreme{tip.length, {at, at + Dim}};
    }
    if (tip.length > shortest[std::size_t(tip.node)]) continue;
    for (int e : around.of(tip.node)) {
      const bool free = solid[std::size_t(e)] == 0;
      for (int n : corners(mesh, e)) {
        go_to(n, tip.length + (free ? 0.0 : distance(mesh, tip.node, n)), tip.begin);
      }
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
    for (int n : corners(mesh, e)) {
      if (at_bottom[std::size_t(n)] != 0) return true;
    }
  }
  return false;
}

template std::optional<Extreme> thinnest_shell(const mesh::Mesh<2>&, std::span<const char>);
template std::optional<Extreme> thinnest_shell(const mesh::Mesh<3>&, std::span<const char>);
template bool melt_touches_bottom(const mesh::Mesh<2>&, std::span<const char>);
template bool melt_touches_bottom(const mesh::Mesh<3>&, std::span<const char>);

}  // namespace dccast::casting
