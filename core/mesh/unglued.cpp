#include "core/mesh/unglued.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

#include "core/mesh/inner_facets.hpp"

namespace dccast::mesh {

namespace {

/// Relative to the shortest edge of a facet: lengths that differ by less are equal.
constexpr double tolerance = 1e-6;

template <int Dim>
using Point = std::array<double, std::size_t(Dim)>;

template <int Dim>
Point<Dim> difference(const double* a, const double* b) {
  Point<Dim> result;
  for (std::size_t d = 0; d < result.size(); ++d) result[d] = a[d] - b[d];
  return result;
}

template <std::size_t N>
double dot(const std::array<double, N>& a, const std::array<double, N>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

template <std::size_t N>
double length(const std::array<double, N>& a) {
  return std::sqrt(dot(a, a));
}

Point<3> cross(const Point<3>& a, const Point<3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Whether a point lies on the line between two others. @param reach  [m] permitted distance
bool lies_between(const double* point, const double* a, const double* b, double reach) {
  const Point<2> along = difference<2>(b, a), to_point = difference<2>(point, a);
  const double share = dot(along, to_point) / dot(along, along);
  const double aside = along[0] * to_point[1] - along[1] * to_point[0];
  return share > 0.0 && share < 1.0 && std::abs(aside) <= reach * length(along);
}

/// Whether a point lies in a triangle or on its edges. @param reach  [m] permitted distance
bool lies_in_triangle(const double* point, const double* a, const double* b, const double* c,
                      double reach) {
  const Point<3> ab = difference<3>(b, a), ac = difference<3>(c, a), ap = difference<3>(point, a);
  const Point<3> normal = cross(ab, ac);
  const double area = length(normal);
  if (std::abs(dot(ap, normal)) > reach * area) return false;

  // Barycentric coordinates of its projection.
  const double of_c = dot(cross(ab, ap), normal) / (area * area);
  const double of_b = dot(cross(ap, ac), normal) / (area * area);
  return std::min({of_b, of_c, 1.0 - of_b - of_c}) >= -tolerance;
}

/// Whether a point lies on a facet. A warped quadrilateral is that of its triangles, over either
/// diagonal.
template <int Dim>
bool lies_on(const Mesh<Dim>& mesh, const Facet<Dim>& facet, const double* point, double reach) {
  const auto corner = [&](std::size_t i) { return mesh.point(facet.node[i]); };
  if constexpr (Dim == 2) {
    return lies_between(point, corner(0), corner(1), reach);
  } else {
    const auto in = [&](std::size_t i, std::size_t j, std::size_t k) {
      return lies_in_triangle(point, corner(i), corner(j), corner(k), reach);
    };
    if (facet.nodes == 3) return in(0, 1, 2);
    return in(0, 1, 2) || in(0, 2, 3) || in(0, 1, 3) || in(1, 2, 3);
  }
}

template <int Dim>
double shortest_edge(const Mesh<Dim>& mesh, const Facet<Dim>& facet) {
  double shortest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < facet.nodes; ++i) {
    const double* a = mesh.point(facet.node[std::size_t(i)]);
    const double* b = mesh.point(facet.node[std::size_t((i + 1) % facet.nodes)]);
    shortest = std::min(shortest, length(difference<Dim>(a, b)));
  }
  return shortest;
}

/// The smallest and largest coordinates of a facet, widened by `reach` [m].
template <int Dim>
struct Box {
  Point<Dim> low, high;

  Box(const Mesh<Dim>& mesh, const Facet<Dim>& facet, double reach) {
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    for (int i = 0; i < facet.nodes; ++i) {
      const double* point = mesh.point(facet.node[std::size_t(i)]);
      for (std::size_t d = 0; d < low.size(); ++d) {
        low[d] = std::min(low[d], point[d] - reach);
        high[d] = std::max(high[d], point[d] + reach);
      }
    }
  }

  bool contains(const double* point) const {
    for (std::size_t d = 0; d < low.size(); ++d)
      if (point[d] < low[d] || point[d] > high[d]) return false;
    return true;
  }
};

/// Nodes in the order of a tree that halves space by one coordinate after the other, so that those
/// in a box are found without looking at all.
template <int Dim>
class NodeTree {
public:
  NodeTree(const Mesh<Dim>& mesh, std::vector<int> nodes) : mesh_(mesh), nodes_(std::move(nodes)) {
    sort(0, nodes_.size(), 0);
  }

  template <class Use>
  void visit(const Box<Dim>& box, Use&& use) const {
    visit(box, 0, nodes_.size(), 0, use);
  }

private:
  static constexpr std::size_t next(std::size_t axis) { return (axis + 1) % std::size_t(Dim); }

  void sort(std::size_t begin, std::size_t end, std::size_t axis) {
    if (end - begin < 2) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return nodes_.begin() + std::ptrdiff_t(i); };
    std::nth_element(at(begin), at(middle), at(end),
                     [&](int a, int b) { return mesh_.point(a)[axis] < mesh_.point(b)[axis]; });
    sort(begin, middle, next(axis));
    sort(middle + 1, end, next(axis));
  }

  template <class Use>
  void visit(const Box<Dim>& box, std::size_t begin, std::size_t end, std::size_t axis,
             Use& use) const {
    if (begin == end) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const double* point = mesh_.point(nodes_[middle]);
    if (box.contains(point)) use(nodes_[middle]);
    if (point[axis] >= box.low[axis]) visit(box, begin, middle, next(axis), use);
    if (point[axis] <= box.high[axis]) visit(box, middle + 1, end, next(axis), use);
  }

  const Mesh<Dim>& mesh_;
  std::vector<int> nodes_;
};

/// All nodes of facets, each once.
template <int Dim>
std::vector<int> nodes_of(std::span<const Facet<Dim>> facets) {
  std::vector<int> nodes;
  for (const Facet<Dim>& facet : facets)
    nodes.insert(nodes.end(), facet.node.begin(), facet.node.begin() + facet.nodes);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace

template <int Dim>
std::optional<Unglued> find_unglued(const Mesh<Dim>& mesh, std::span<const Facet<Dim>> outer) {
  const NodeTree<Dim> tree(mesh, nodes_of(outer));
  std::set<int> found;
  Unglued first;

  for (const Facet<Dim>& facet : outer) {
    const auto corners = std::span(facet.node).first(std::size_t(facet.nodes));
    const double reach = tolerance * shortest_edge(mesh, facet);

    tree.visit(Box<Dim>(mesh, facet, reach), [&](int node) {
      if (std::ranges::count(corners, node) > 0) return;
      const double* point = mesh.point(node);
      const auto same = std::ranges::find_if(corners, [&](int corner) {
        return length(difference<Dim>(mesh.point(corner), point)) <= reach;
      });
      if (same == corners.end() && !lies_on(mesh, facet, point, reach)) return;

      found.insert(node);
      if (first.node >= 0) return;
      first = {.node = node, .same_place = same == corners.end() ? -1 : *same};
    });
  }

  if (found.empty()) return std::nullopt;
  first.nodes = found.size();
  return first;
}

Pieces find_pieces(int elements, std::span<const std::pair<int, int>> neighbours) {
  JoinedPieces joined(elements);
  for (const auto& [a, b] : neighbours) joined.join(a, b);

  Pieces pieces{.number = 0};
  for (int e = 0; e < elements; ++e) {
    if (joined.first_of(e) == e) ++pieces.number;
    if (pieces.second < 0 && joined.first_of(e) != 0) pieces.second = e;
  }
  return pieces;
}

template std::optional<Unglued> find_unglued(const Mesh<2>&, std::span<const Facet<2>>);
template std::optional<Unglued> find_unglued(const Mesh<3>&, std::span<const Facet<3>>);

}  // namespace dccast::mesh
