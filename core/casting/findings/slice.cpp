#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/casting/findings/shell.hpp"
#include "core/mesh/cell_shape.hpp"

namespace dccast::casting {

namespace {

/// A temperature [°C] at a point of the cut.
template <int Dim>
using CutPoint = Located<Dim>;

template <int Dim>
CutPoint<Dim> interpolate(const CutPoint<Dim>& a, const CutPoint<Dim>& b, double share) {
  CutPoint<Dim> point;
  for (std::size_t d = 0; d < Dim; ++d)
    point.place[d] = a.place[d] + share * (b.place[d] - a.place[d]);
  point.value = a.value + share * (b.value - a.value);
  return point;
}

/// A stretch of the side on the cut; in 2D both ends are one point.
template <int Dim>
struct SidePiece {
  CutPoint<Dim> begin, end;
};

/// Distance of a point from a piece of the side [m].
template <int Dim>
double distance(const std::array<double, Dim>& p, const SidePiece<Dim>& piece) {
  double along = 0.0, squared = 0.0;
  for (std::size_t d = 0; d < Dim; ++d) {
    const double step = piece.end.place[d] - piece.begin.place[d];
    along += step * (p[d] - piece.begin.place[d]);
    squared += step * step;
  }

  // The nearest point of the piece: the projection, limited to its ends.
  const double share = squared > 0.0 ? std::clamp(along / squared, 0.0, 1.0) : 0.0;

  double sum = 0.0;
  for (std::size_t d = 0; d < Dim; ++d) {
    const double step = piece.end.place[d] - piece.begin.place[d];
    sum += std::pow(p[d] - piece.begin.place[d] - share * step, 2);
  }
  return std::sqrt(sum);
}

/// A horizontal cut through a mesh.
template <int Dim>
class Cut {
public:
  Cut(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature, double height)
      : mesh_(mesh), temperature_(temperature), height_(height) {
    mesh::for_each_facet(mesh, mesh::PatchKind::side,
                         [this](const auto& facet, const auto&) { add_side(facet); });
  }

  const std::vector<SidePiece<Dim>>& side() const { return side_; }

  double distance_from_side(const std::array<double, Dim>& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& piece : side_) nearest = std::min(nearest, distance<Dim>(p, piece));
    return nearest;
  }

  /// Calls use(points) with the points where the edges of an element meet the cut.
  template <class Use>
  void for_each_element(Use&& use) const {
    const auto& edges = mesh::cell_shape(Dim, mesh_.nodes_per_element).edges;
    std::vector<CutPoint<Dim>> points;
    for (int e = 0; e < mesh_.elements(); ++e) {
      const int* node = mesh_.nodes_of(e);
      if (!meets(node)) continue;

      points.clear();
      for (const auto& [a, b] : edges) add_crossing(node[a], node[b], points);
      if (!points.empty()) use(points);
    }
  }

private:
  double height(int n) const { return mesh_.point(n)[Dim - 1]; }
  CutPoint<Dim> point(int n) const {
    CutPoint<Dim> p;
    std::copy_n(mesh_.point(n), Dim, p.place.begin());
    p.value = temperature_[std::size_t(n)];
    return p;
  }
  /// Whether an element meets the cut; most lie above or below it as a whole.
  bool meets(const int* node) const {
    double lowest = height(node[0]), highest = lowest;
    for (int i = 1; i < mesh_.nodes_per_element; ++i) {
      lowest = std::min(lowest, height(node[i]));
      highest = std::max(highest, height(node[i]));
    }
    return lowest <= height_ && height_ <= highest;
  }
  /// Adds the point where an edge crosses the cut. An edge that lies in the cut adds nothing: its
  /// ends are on other edges.
  void add_crossing(int a, int b, std::vector<CutPoint<Dim>>& points) const {
    const double below = height(a) - height_, above = height(b) - height_;
    if (below * above > 0.0 || below == above) return;
    points.push_back(interpolate(point(a), point(b), below / (below - above)));
  }
  void add_side(const mesh::Facet<Dim>& facet) {
    std::vector<CutPoint<Dim>> points;
    for (int i = 0; i < facet.nodes; ++i)
      add_crossing(facet.node[std::size_t(i)], facet.node[std::size_t((i + 1) % facet.nodes)],
                   points);
    if (!points.empty()) side_.push_back({points.front(), points.back()});
  }

  const mesh::Mesh<Dim>& mesh_;
  std::span<const double> temperature_;
  double height_;
  std::vector<SidePiece<Dim>> side_;
};

/// Distance of two points [m].
template <int Dim>
double apart(const std::array<double, Dim>& a, const std::array<double, Dim>& b) {
  double squared = 0.0;
  for (std::size_t d = 0; d < Dim; ++d) squared += (a[d] - b[d]) * (a[d] - b[d]);
  return std::sqrt(squared);
}

/// The point of the isotherm nearest to the side and its distance [m], infinite if there is none.
template <int Dim>
Located<Dim> nearest_hot(const Cut<Dim>& cut, double isotherm) {
  Located<Dim> nearest{std::numeric_limits<double>::infinity(), {}}, last;
  cut.for_each_element([&](const auto& points) {
    for (const auto& cold : points)
      for (const auto& hot : points) {
        if (cold.value >= isotherm || hot.value < isotherm) continue;

        // The temperature is linear between a cold and a hot point.
        const double share = (isotherm - cold.value) / (hot.value - cold.value);
        const auto place = interpolate(cold, hot, share).place;
        // The depth changes by at most the distance between two points: few need a search.
        if (last.value - apart<Dim>(place, last.place) >= nearest.value) continue;
        last = {cut.distance_from_side(place), place};
        if (last.value < nearest.value) nearest = last;
      }
  });
  return nearest;
}

/// The point of the cut farthest from the side and its distance [m].
template <int Dim>
Located<Dim> farthest_from_side(const Cut<Dim>& cut) {
  Located<Dim> farthest, last;
  cut.for_each_element([&](const auto& points) {
    for (const auto& point : points) {
      if (last.value + apart<Dim>(point.place, last.place) <= farthest.value) continue;
      last = {cut.distance_from_side(point.place), point.place};
      if (last.value > farthest.value) farthest = last;
    }
  });
  return farthest;
}

/// The hottest end of all pieces of the side.
template <int Dim>
CutPoint<Dim> hottest(const std::vector<SidePiece<Dim>>& side) {
  CutPoint<Dim> found = side.front().begin;
  for (const auto& piece : side)
    for (const auto* end : {&piece.begin, &piece.end})
      if (end->value > found.value) found = *end;
  return found;
}

template <int Dim>
CutPoint<Dim> node_point(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature, int n) {
  CutPoint<Dim> p{temperature[std::size_t(n)], {}};
  std::copy_n(mesh.point(n), Dim, p.place.begin());
  return p;
}

double size_of(const std::array<CutPoint<2>, 2>& edge) {  // [m]
  return std::hypot(edge[1].place[0] - edge[0].place[0], edge[1].place[1] - edge[0].place[1]);
}
double size_of(const std::array<CutPoint<3>, 3>& triangle) {  // [m2]
  std::array<double, 3> a{}, b{};
  for (std::size_t d = 0; d < 3; ++d) {
    a[d] = triangle[1].place[d] - triangle[0].place[d];
    b[d] = triangle[2].place[d] - triangle[0].place[d];
  }
  return 0.5 * std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                          a[0] * b[1] - a[1] * b[0]);
}

/// Share of an edge or triangle hotter than an isotherm [1]. The corner that is alone on its side
/// of the isotherm cuts off a part that is similar to the whole along each of its edges.
template <int Dim, std::size_t Corners>
double hot_share(std::array<CutPoint<Dim>, Corners> simplex, double isotherm) {
  std::ranges::sort(simplex, {}, &CutPoint<Dim>::value);
  const auto cold =
      std::ranges::count_if(simplex, [&](const auto& p) { return p.value < isotherm; });
  if (cold == 0) return 1.0;
  if (cold == static_cast<std::ptrdiff_t>(Corners)) return 0.0;

  const bool one_is_cold = cold == 1;
  const CutPoint<Dim>& alone = one_is_cold ? simplex.front() : simplex.back();
  double part = 1.0;
  for (const auto& other : simplex)
    if (&other != &alone) part *= (isotherm - alone.value) / (other.value - alone.value);
  return one_is_cold ? 1.0 - part : part;
}

template <int Dim>
double node_height(const mesh::Mesh<Dim>& mesh, int n) {
  return mesh.point(n)[Dim - 1];
}

/// Nodes at which most symmetry planes meet, lowest first.
template <int Dim>
std::vector<int> find_axis(const mesh::Mesh<Dim>& mesh) {
  std::vector<int> planes_at(std::size_t(mesh.nodes()), 0);
  int most = 1;
  for (const auto& patch : mesh.patches) {
    if (patch.kind != mesh::PatchKind::symmetry) continue;
    for (const int n : mesh::patch_nodes(patch)) most = std::max(most, ++planes_at[std::size_t(n)]);
  }

  std::vector<int> nodes;
  for (int n = 0; n < mesh.nodes(); ++n)
    if (planes_at[std::size_t(n)] == most) nodes.push_back(n);
  std::ranges::sort(nodes, {}, [&](int n) { return node_height(mesh, n); });
  return nodes;
}

/// The largest value at the points where edges of the sides cross a height within their range.
template <int Dim>
double largest_crossing(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                        double height) {
  double largest = -INFINITY;
  const auto add_crossing = [&](int a, int b) {
    const double low = node_height(mesh, a), high = node_height(mesh, b);
    if (low >= height || high < height) return;

    const double share = (height - low) / (high - low);
    largest = std::max(
        largest, (1.0 - share) * temperature[std::size_t(a)] + share * temperature[std::size_t(b)]);
  };

  // Each edge in both directions: add_crossing() takes the lower end first.
  mesh::for_each_facet(mesh, mesh::PatchKind::side, [&](const auto& facet, const auto&) {
    const std::size_t corners = std::size_t(facet.nodes);
    for (std::size_t i = 0; i < corners; ++i) {
      const int a = facet.node[i], b = facet.node[(i + 1) % corners];
      add_crossing(a, b);
      add_crossing(b, a);
    }
  });
  return largest;
}

/// The largest value of the nodes at one height.
template <int Dim>
double largest_at(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                  std::span<const int> nodes, double height) {
  constexpr double same_height = 1e-9;  // [m]
  double largest = -INFINITY;
  for (const int n : nodes)
    if (std::abs(node_height(mesh, n) - height) <= same_height)
      largest = std::max(largest, temperature[std::size_t(n)]);
  return largest;
}

}  // namespace

template <int Dim>
std::optional<Slice<Dim>> slice_at(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                                   double height, double isotherm) {
  const Cut<Dim> cut(mesh, temperature, height);
  if (cut.side().empty()) return std::nullopt;
  const Located<Dim> surface = hottest(cut.side());
  if (surface.value >= isotherm) return Slice<Dim>{surface, {0.0, surface.place}};

  const Located<Dim> shell = nearest_hot(cut, isotherm);
  return Slice<Dim>{surface, std::isfinite(shell.value) ? shell : farthest_from_side(cut)};
}

template <int Dim>
Located<Dim> unfrozen_side(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                           double isotherm) {
  double hot = 0.0, whole = 0.0, lowest = HUGE_VAL, highest = -HUGE_VAL;
  Located<Dim> rim;
  mesh::for_each_facet(mesh, mesh::PatchKind::side, [&](const auto& facet, const auto&) {
    std::array<CutPoint<Dim>, 4> corner;
    for (std::size_t i = 0; i < std::size_t(facet.nodes); ++i) {
      corner[i] = node_point(mesh, temperature, facet.node[i]);
      const double height = corner[i].place[Dim - 1];
      lowest = std::min(lowest, height);
      highest = std::max(highest, height);
      if (corner[i].value < isotherm && height > rim.place[Dim - 1]) rim.place = corner[i].place;
    }

    // An edge of a section; triangles of a solid, two of a quadrilateral.
    for (std::size_t i = Dim - 1; i < std::size_t(facet.nodes); ++i) {
      std::array<CutPoint<Dim>, Dim> simplex;
      if constexpr (Dim == 2)
        simplex = {corner[0], corner[i]};
      else
        simplex = {corner[0], corner[i - 1], corner[i]};
      const double size = size_of(simplex);
      whole += size;
      hot += size * hot_share(simplex, isotherm);
    }
  });

  if (whole > 0.0) rim.value = hot / whole * (highest - lowest);
  return rim;
}

template <int Dim>
std::optional<Located<Dim>> hottest_side_at(const mesh::Mesh<Dim>& mesh,
                                            std::span<const double> temperature, double height) {
  const Cut<Dim> cut(mesh, temperature, height);
  if (cut.side().empty()) return std::nullopt;
  return hottest(cut.side());
}

template <int Dim>
double side_temperature(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                        double height) {
  const std::vector<int> side = mesh::patch_nodes(mesh, mesh::PatchKind::side);
  if (side.empty()) return 0.0;

  const auto by_height = [&](int n) { return node_height(mesh, n); };
  const double lowest = node_height(mesh, *std::ranges::min_element(side, {}, by_height));
  const double highest = node_height(mesh, *std::ranges::max_element(side, {}, by_height));

  if (lowest >= height) return largest_at(mesh, temperature, side, lowest);
  if (highest < height) return largest_at(mesh, temperature, side, highest);
  return largest_crossing(mesh, temperature, height);
}

template <int Dim>
double sump_depth(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                  double metal_level, double isotherm) {
  const std::vector<int> axis = find_axis(mesh);
  // Down the axis, from the top to the first crossing of the isotherm.
  for (std::size_t i = axis.size(); i-- > 1;) {
    const double above = temperature[std::size_t(axis[i])];
    const double below = temperature[std::size_t(axis[i - 1])];
    if (above < isotherm) return metal_level - node_height(mesh, axis[i]);
    if (below >= isotherm) continue;

    const double share = (above - isotherm) / (above - below);
    const double top = node_height(mesh, axis[i]), bottom = node_height(mesh, axis[i - 1]);
    return metal_level - (top + share * (bottom - top));
  }
  return metal_level - node_height(mesh, axis.front());
}

template std::optional<Slice<2>> slice_at(const mesh::Mesh<2>&, std::span<const double>, double,
                                          double);
template std::optional<Slice<3>> slice_at(const mesh::Mesh<3>&, std::span<const double>, double,
                                          double);
template Located<2> unfrozen_side(const mesh::Mesh<2>&, std::span<const double>, double);
template Located<3> unfrozen_side(const mesh::Mesh<3>&, std::span<const double>, double);
template std::optional<Located<2>> hottest_side_at(const mesh::Mesh<2>&, std::span<const double>,
                                                   double);
template std::optional<Located<3>> hottest_side_at(const mesh::Mesh<3>&, std::span<const double>,
                                                   double);
template double side_temperature(const mesh::Mesh<2>&, std::span<const double>, double);
template double side_temperature(const mesh::Mesh<3>&, std::span<const double>, double);
template double sump_depth(const mesh::Mesh<2>&, std::span<const double>, double, double);
template double sump_depth(const mesh::Mesh<3>&, std::span<const double>, double, double);

}  // namespace dccast::casting
