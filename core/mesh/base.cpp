#include "core/mesh/base.hpp"

#include <algorithm>
#include <cmath>

#include "core/mesh/graded_cells.hpp"

namespace dccast::mesh {

namespace {

/// Positions from zero to `length`, the last cell of width `last` [m].
std::vector<double> graded_towards_end(double length, int cells, double last) {
  std::vector<double> widths = graded_cells(length, cells, last);
  std::reverse(widths.begin(), widths.end());
  return ends_of_cells(widths, length);
}

/// Moves the nearest inner position onto each kink of the opening, so that a straight piece of the
/// mould is one of the mesh.
void snap_to_kinks(const Curve& opening, std::vector<double>& x) {
  for (const double kink : opening.at()) {
    if (x.size() < 3 || kink <= x.front() || kink >= x.back()) continue;
    const auto nearest = std::min_element(x.begin() + 1, x.end() - 1, [&](double a, double b) {
      return std::abs(a - kink) < std::abs(b - kink);
    });
    *nearest = kink;
  }
}

/// The plan of a quarter slab under construction: a grid of columns along x and layers along y.
class QuarterPlan {
public:
  explicit QuarterPlan(const SectionSpec& spec)
      : opening_(spec.half_thickness),
        x_(columns(spec)),
        share_(layers(spec)),
        column_(static_cast<int>(share_.size())) {}

  Base<3> build() const {
    Base<3> base;
    for (const double x : x_)
      for (const double share : share_) base.node.insert(base.node.end(), {x, share * opening_(x)});
    for (int i = 0; i < cells_x(); ++i)
      for (int j = 0; j < cells_y(); ++j)
        for (const int n : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)})
          base.cell_node.push_back(n);
    add_straight_walls(base);
    add_wide_faces(base);
    return base;
  }

private:
  static std::vector<double> columns(const SectionSpec& spec) {
    auto x = graded_towards_end(spec.half_width, spec.columns, spec.side_cell);
    snap_to_kinks(spec.half_thickness, x);
    return refined(x, spec.refinement);
  }
  static std::vector<double> layers(const SectionSpec& spec) {
    const double end = spec.half_thickness(spec.half_width);
    auto y = graded_towards_end(end, spec.layers, spec.wide_side_cell);
    for (double& at : y) at /= end;
    return refined(y, spec.refinement);
  }

  int cells_x() const { return static_cast<int>(x_.size()) - 1; }
  int cells_y() const { return column_ - 1; }
  int at(int i, int j) const { return i * column_ + j; }
  int cell(int i, int j) const { return i * cells_y() + j; }

  void add_straight_walls(Base<3>& base) const {
    Base<3>::Wall plane_x{"symmetry_x", PatchKind::symmetry, {-1, 0, 0}, {}};
    Base<3>::Wall plane_y{"symmetry_y", PatchKind::symmetry, {0, -1, 0}, {}};
    Base<3>::Wall narrow{"side_x", PatchKind::side, {1, 0, 0}, {}};
    for (int j = 0; j < cells_y(); ++j) {
      plane_x.pieces.push_back({cell(0, j), 3});
      narrow.pieces.push_back({cell(cells_x() - 1, j), 1});
    }
    for (int i = 0; i < cells_x(); ++i) plane_y.pieces.push_back({cell(i, 0), 0});
    for (auto* wall : {&plane_x, &plane_y, &narrow}) base.walls.push_back(std::move(*wall));
  }

  /// One wall for each straight piece of the opening: side_y, side_y_2, side_y_3.
  void add_wide_faces(Base<3>& base) const {
    constexpr double same_direction = 1e-9;
    int faces = 0;
    for (int i = 0; i < cells_x(); ++i) {
      const auto normal = normal_of_column(std::size_t(i));
      auto* wall = faces == 0 ? nullptr : &base.walls.back();
      if (wall == nullptr || std::abs(wall->normal[0] - normal[0]) > same_direction) {
        ++faces;
        const std::string name = faces == 1 ? "side_y" : "side_y_" + std::to_string(faces);
        base.walls.push_back({name, PatchKind::side, normal, {}});
      }
      base.walls.back().pieces.push_back({cell(i, cells_y() - 1), 2});
    }
  }

  std::array<double, 3> normal_of_column(std::size_t i) const {
    const double along = x_[i + 1] - x_[i], rise = opening_(x_[i + 1]) - opening_(x_[i]);
    const double length = std::hypot(along, rise);
    return {-rise / length, along / length, 0.0};
  }

  const Curve& opening_;
  std::vector<double> x_;      ///< [m] of the columns of nodes
  std::vector<double> share_;  ///< of the opening, by layer of nodes [1]
  int column_;                 ///< nodes in one
};

}  // namespace

template <>
Base<2> base_of<2>(const SectionSpec& spec) {
  Base<2> base;
  base.node =
      refined(graded_towards_end(spec.half_width, spec.columns, spec.side_cell), spec.refinement);
  const int cells = base.nodes() - 1;
  for (int c = 0; c < cells; ++c) base.cell_node.insert(base.cell_node.end(), {c, c + 1});
  base.walls.push_back({"symmetry", PatchKind::symmetry, {-1, 0}, {{0, 0}}});
  base.walls.push_back({"side", PatchKind::side, {1, 0}, {{cells - 1, 1}}});
  return base;
}

template <>
Base<3> base_of<3>(const SectionSpec& spec) {
  return QuarterPlan(spec).build();
}

}  // namespace dccast::mesh
