#include "core/mesh/base.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/mesh/extrusion.hpp"

namespace dccast::mesh {

namespace {

/// Slope of the opening at the narrow face [1].
double end_slope(const Curve& opening, double half_width) {
  if (opening.constant()) return 0.0;
  double last_kink = 0.0;
  for (const double x : opening.at())
    if (x < half_width) last_kink = std::max(last_kink, x);
  return (opening(half_width) - opening(last_kink)) / (half_width - last_kink);
}

/// Positions from zero to `length`, the last cell of width `last` [m].
std::vector<double> graded_towards_end(double length, int cells, double last) {
  std::vector<double> widths = graded_cells(length, cells, last);
  std::reverse(widths.begin(), widths.end());
  return ends_of_cells(widths, length);
}

template <class Iterator>
Iterator find_nearest(double target, Iterator first, Iterator end) {
  return std::min_element(
      first, end, [&](double a, double b) { return std::abs(a - target) < std::abs(b - target); });
}

/// Moves the nearest inner position to a given one, so that a row of nodes lies there.
void snap(double target, std::vector<double>& position) {
  if (position.size() < 3 || target <= position.front() || target >= position.back()) return;
  *find_nearest(target, position.begin() + 1, position.end() - 1) = target;
}

int nearest_index(double target, const std::vector<double>& position) {
  return static_cast<int>(find_nearest(target, position.begin(), position.end()) -
                          position.begin());
}

/// Outward unit normal of a piece of the rim [1]. Cells turn counterclockwise, so that the outside
/// is to the right of their sides.
std::array<double, 3> outward_normal(const Base<3>& base, const Base<3>::Piece& piece) {
  const auto [from, to] = ends_of(base, piece);
  const double along = to[0] - from[0], rise = to[1] - from[1];
  const double length = std::hypot(along, rise);
  return {rise / length, -along / length, 0.0};
}

/// The plan of a quarter slab under construction: a grid of columns along x and layers along y.
class QuarterPlan {
public:
  QuarterPlan(const SectionSpec& spec, Plan plan)
      : spec_(spec),
        x_(columns(spec, plan)),
        share_(layers(spec, plan)),
        column_(static_cast<int>(share_.size())),
        patch_column_(cells_x()),
        patch_layer_(cells_y()) {
    for (const double x : x_)
      for (const double share : share_)
        place_.insert(place_.end(), {x, share * spec.half_thickness(x)});
    if (spec.corner_radius > 0.0) round_corner();
  }

  /// The finished plan, with its walls.
  Base<3> build() const {
    Base<3> base;
    base.node = place_;
    for (int i = 0; i < cells_x(); ++i)
      for (int j = 0; j < cells_y(); ++j)
        for (const int n : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)})
          base.cell_node.push_back(n);

    add_straight_walls(base);
    add_wide_faces(base);
    add_corner(base);
    return base;
  }

  /// @see mesh::corner_cells()
  std::array<int, 2> corner_cells() const {
    return {cells_x() - patch_column_, cells_y() - patch_layer_};
  }

private:
  /// Positions of the columns of nodes [m].
  static std::vector<double> columns(const SectionSpec& spec, Plan plan) {
    auto x = graded_towards_end(spec.half_width, spec.columns, spec.side_cell);

    // Straight pieces of the mould end at nodes.
    for (const double kink : spec.half_thickness.at()) snap(kink, x);
    if (spec.corner_radius > 0.0) snap(corner_arc(spec).on_wide_face()[0], x);

    return refined(x, spec.refinement * (plan == Plan::heat ? spec.heat_cells.per_column : 1));
  }
  /// Positions of the layers of nodes, relative to the opening [1].
  static std::vector<double> layers(const SectionSpec& spec, Plan plan) {
    const double end = spec.half_thickness(spec.half_width);
    auto y = graded_towards_end(end, spec.layers, spec.wide_side_cell);
    if (spec.corner_radius > 0.0) snap(corner_arc(spec).on_narrow_face()[1], y);
    for (double& position : y) position /= end;
    return refined(y, spec.refinement * (plan == Plan::heat ? spec.heat_cells.per_layer : 1));
  }

  /// Finds the cells at the rounded corner and moves their nodes to the arc.
  void round_corner() {
    const CornerArc arc = corner_arc(spec_);
    const double end = spec_.half_thickness(spec_.half_width);
    patch_column_ = nearest_index(arc.on_wide_face()[0], x_);
    patch_layer_ = nearest_index(arc.on_narrow_face()[1] / end, share_);
    if (patch_column_ < cells_x() && patch_layer_ < cells_y()) bend_patch(arc);
  }

  /// Moves the points of the corner patch: those on its two outer sides to the arc, at equal angles
  /// on half the arc each; those inside by transfinite interpolation between its four sides.
  void bend_patch(const CornerArc& arc) {
    const int m = cells_x() - patch_column_, n = cells_y() - patch_layer_;
    const auto point = [&](int i, int j) {
      return &place_[2 * std::size_t(at(patch_column_ + i, patch_layer_ + j))];
    };
    const auto move_to = [&](int i, int j, const CornerArc::Point& p) {
      std::copy(p.begin(), p.end(), point(i, j));
    };

    // The two outer sides of the patch become the two halves of the arc.
    const double middle = 0.5 * arc.angle;
    for (int i = 0; i <= m; ++i) move_to(i, n, arc.point(arc.angle + (middle - arc.angle) * i / m));
    for (int j = 0; j <= n; ++j) move_to(m, j, arc.point(middle * j / n));

    // Transfinite interpolation: both pairs of sides, less the bilinear part of the four corners.
    for (int i = 1; i < m; ++i)
      for (int j = 1; j < n; ++j) {
        const double u = double(i) / m, v = double(j) / n;
        CornerArc::Point p;
        for (std::size_t d = 0; d < 2; ++d)
          p[d] = (1 - u) * point(0, j)[d] + u * point(m, j)[d] + (1 - v) * point(i, 0)[d] +
                 v * point(i, n)[d] - (1 - u) * (1 - v) * point(0, 0)[d] -
                 u * (1 - v) * point(m, 0)[d] - (1 - u) * v * point(0, n)[d] -
                 u * v * point(m, n)[d];
        move_to(i, j, p);
      }
  }

  int cells_x() const { return static_cast<int>(x_.size()) - 1; }
  int cells_y() const { return column_ - 1; }
  int at(int i, int j) const { return i * column_ + j; }
  int cell(int i, int j) const { return i * cells_y() + j; }

  void add_straight_walls(Base<3>& base) const {
    Base<3>::Wall plane_x{"symmetry_x", PatchKind::symmetry, {-1, 0, 0}, {}};
    Base<3>::Wall plane_y{"symmetry_y", PatchKind::symmetry, {0, -1, 0}, {}};
    Base<3>::Wall narrow{"side_x", PatchKind::side, {1, 0, 0}, {}};

    for (int j = 0; j < cells_y(); ++j) plane_x.pieces.push_back({cell(0, j), 3});
    for (int j = 0; j < patch_layer_; ++j) narrow.pieces.push_back({cell(cells_x() - 1, j), 1});
    for (int i = 0; i < cells_x(); ++i) plane_y.pieces.push_back({cell(i, 0), 0});

    for (auto* wall : {&plane_x, &plane_y, &narrow})
      if (!wall->pieces.empty()) base.walls.push_back(std::move(*wall));
  }

  /// One wall for each straight piece of the opening: side_y, side_y_2, side_y_3.
  void add_wide_faces(Base<3>& base) const {
    const std::size_t first = base.walls.size();
    for (int i = 0; i < patch_column_; ++i)
      add_piece(base, first, "side_y", {cell(i, cells_y() - 1), 2});
  }

  /// One wall for each chord of a rounded corner, from the wide to the narrow face.
  void add_corner(Base<3>& base) const {
    const std::size_t first = base.walls.size();
    for (int i = patch_column_; i < cells_x(); ++i)
      add_piece(base, first, "side_corner", {cell(i, cells_y() - 1), 2});
    for (int j = cells_y() - 1; j >= patch_layer_; --j)
      add_piece(base, first, "side_corner", {cell(cells_x() - 1, j), 1});
  }

  const SectionSpec& spec_;
  std::vector<double> x_;      ///< (column of nodes) [m]
  std::vector<double> share_;  ///< (layer of nodes) y relative to the opening [1]
  int column_;                 ///< nodes in a column
  /// Column and layer at which the arc ends on the wide and on the narrow face; the last ones if
  /// the corner is square.
  int patch_column_, patch_layer_;
  std::vector<double> place_;  ///< (column, layer, 2) [m]
};

}  // namespace

CornerArc::Point CornerArc::point(double direction) const {
  return {centre[0] + radius * std::cos(direction), centre[1] + radius * std::sin(direction)};
}

CornerArc corner_arc(const SectionSpec& spec) {
  const double slope = end_slope(spec.half_thickness, spec.half_width);
  const double length = std::hypot(1.0, slope);
  const double normal_x = -slope / length, normal_y = 1.0 / length;
  const double end = spec.half_thickness(spec.half_width);

  // The centre lies one radius inside both faces.
  const double y = end - spec.corner_radius * (1.0 - normal_x) / normal_y;
  return {spec.corner_radius,
          {spec.half_width - spec.corner_radius, y},
          std::atan2(normal_y, normal_x)};
}

template <>
Base<2> base_of<2>(const SectionSpec& spec, Plan) {
  Base<2> base;
  base.node =
      refined(graded_towards_end(spec.half_width, spec.columns, spec.side_cell), spec.refinement);

  const int cells = base.nodes() - 1;
  for (int c = 0; c < cells; ++c) base.cell_node.insert(base.cell_node.end(), {c, c + 1});
  base.walls.push_back({"symmetry", PatchKind::symmetry, {-1, 0}, {{0, 0}}});
  base.walls.push_back({"side", PatchKind::side, {1, 0}, {{cells - 1, 1}}});

  if (spec.bowl)
    for (const double x : base.node)
      base.depth.push_back(spec.bowl->depth_at(distance_from_edge(spec, x)));
  return base;
}

template <>
Base<3> base_of<3>(const SectionSpec& spec, Plan plan) {
  Base<3> base = QuarterPlan(spec, plan).build();

  if (spec.bowl) {
    for (std::size_t n = 0; n < base.node.size(); n += 2) {
      const double inward = distance_from_edge(spec, base, base.node[n], base.node[n + 1]);
      base.depth.push_back(spec.bowl->depth_at(inward));
    }
  }
  return base;
}

double distance_from_edge(const SectionSpec& spec, double x) {
  return spec.half_width - x;
}

double distance_from_edge(const SectionSpec& spec, const Base<3>& plan, double x, double y) {
  return std::min(distance_from_edge(spec, x), reach_of(plan, x) - y);
}

std::array<const double*, 2> ends_of(const Base<3>& plan, const Base<3>::Piece& piece) {
  const int* corner = &plan.cell_node[std::size_t(4 * piece.cell)];
  const auto point = [&](int k) { return &plan.node[2 * std::size_t(corner[k % 4])]; };
  return {point(piece.side), point(piece.side + 1)};
}

void add_piece(Base<3>& base, std::size_t first, const std::string& name,
               const Base<3>::Piece& piece) {
  constexpr double same_direction = 1e-9;
  const auto normal = outward_normal(base, piece);
  const auto has_direction = [&](const Base<3>::Wall& wall) {
    return std::hypot(wall.normal[0] - normal[0], wall.normal[1] - normal[1]) <= same_direction;
  };
  const auto begin = base.walls.begin() + static_cast<std::ptrdiff_t>(first);
  const auto same = std::find_if(begin, base.walls.end(), has_direction);
  if (same != base.walls.end()) return same->pieces.push_back(piece);

  // A wall of another group may already have the next name.
  std::size_t count = base.walls.size() - first + 1;
  const auto numbered = [&] { return count == 1 ? name : fmt::format("{}_{}", name, count); };
  while (std::ranges::count(base.walls, numbered(), &Base<3>::Wall::name) > 0) ++count;
  base.walls.push_back({numbered(), PatchKind::side, normal, {piece}});
}

std::array<int, 2> corner_cells(const SectionSpec& spec) {
  return QuarterPlan(spec, Plan::mechanics).corner_cells();
}

double reach_of(const Base<3>& plan, double x) {
  constexpr double round_off = 1e-12;  // [m]
  double reach = 0.0;
  for (const auto& wall : plan.walls) {
    if (wall.kind != PatchKind::side) continue;

    for (const auto& piece : wall.pieces) {
      const auto [a, b] = ends_of(plan, piece);
      if (x < std::min(a[0], b[0]) - round_off || x > std::max(a[0], b[0]) + round_off) continue;

      const bool along_y = a[0] == b[0];
      const double share = along_y ? 0.0 : (x - a[0]) / (b[0] - a[0]);
      const double end = along_y ? std::max(a[1], b[1]) : a[1] + share * (b[1] - a[1]);
      reach = std::max(reach, end);
    }
  }
  return reach;
}

}  // namespace dccast::mesh
