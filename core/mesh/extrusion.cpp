#include "core/mesh/extrusion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dccast::mesh {

namespace {

/// Sum of 1 + r + ... + r^(n-1) with r = exp(log_ratio); without cancellation where r is near one.
double geometric_sum(double log_ratio, int terms) {
  return log_ratio == 0.0 ? terms : std::expm1(terms * log_ratio) / std::expm1(log_ratio);
}

}  // namespace

std::vector<double> graded_cells(double length, int cells, double first) {
  // Monotone in the ratio, so bisection on its logarithm cannot miss.
  double low = -3.0, high = 3.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (first * geometric_sum(middle, cells) < length ? low : high) = middle;
  }
  const double log_ratio = 0.5 * (low + high);
  std::vector<double> widths;
  const double scale = length / geometric_sum(log_ratio, cells);
  for (int i = 0; i < cells; ++i) widths.push_back(scale * std::exp(log_ratio * i));
  return widths;
}

std::vector<double> ends_of_cells(const std::vector<double>& widths, double length) {
  std::vector<double> at{0.0};
  for (double w : widths) at.push_back(at.back() + w);
  at.back() = length;  // without the rounding of the sum: patches must close
  return at;
}

std::vector<double> refined(const std::vector<double>& at, int refinement) {
  std::vector<double> fine{at.front()};
  for (std::size_t i = 1; i < at.size(); ++i) {
    for (int k = 1; k < refinement; ++k) {
      fine.push_back(at[i - 1] + (at[i] - at[i - 1]) * k / refinement);
    }
    fine.push_back(at[i]);
  }
  return fine;
}

// Corners in 2D: 0 and 1 below, 2 above 0, 3 above 1. In 3D: 0 to 3 below, 4 to 7 above them.

template <>
const CellDivision<2>& division_of<2>(ElementKind kind) {
  static const CellDivision<2> whole{
      {{0, 1, 3, 2}}, {{{0, 1}, 0}}, {{{3, 2}, 0}}, {{{{2, 0}, 0}}, {{{1, 3}, 0}}}};
  static const CellDivision<2> triangles{
      {{0, 1, 3}, {0, 3, 2}}, {{{0, 1}, 0}}, {{{3, 2}, 1}}, {{{{2, 0}, 1}}, {{{1, 3}, 0}}}};
  return kind == ElementKind::p1 ? triangles : whole;
}

template <>
const CellDivision<3>& division_of<3>(ElementKind kind) {
  static const CellDivision<3> whole{
      {{0, 1, 2, 3, 4, 5, 6, 7}},
      {{{0, 3, 2, 1}, 0}},
      {{{4, 5, 6, 7}, 0}},
      {{{{0, 1, 5, 4}, 0}}, {{{1, 2, 6, 5}, 0}}, {{{2, 3, 7, 6}, 0}}, {{{3, 0, 4, 7}, 0}}}};
  // Six around the diagonal from 0 to 6. Every face is cut from its corner nearest to 0 to the one
  // opposite, so that cells whose base starts at the same corner fit together.
  static const CellDivision<3> tetrahedra{
      {{0, 1, 2, 6}, {0, 5, 1, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 4, 5, 6}, {0, 7, 4, 6}},
      {{{0, 3, 2}, 2}, {{0, 2, 1}, 0}},
      {{{4, 5, 6}, 4}, {{4, 6, 7}, 5}},
      {{{{0, 1, 5}, 1}, {{0, 5, 4}, 4}},
       {{{1, 2, 6}, 0}, {{1, 6, 5}, 1}},
       {{{2, 3, 6}, 2}, {{3, 7, 6}, 3}},
       {{{3, 0, 7}, 3}, {{0, 4, 7}, 5}}}};
  return kind == ElementKind::p1 ? tetrahedra : whole;
}

namespace {

/// Every row of nodes stands above the lowest.
bool stands_upright(const Mesh<3>& mesh, const Extrusion& rows) {
  for (int n = 0; n < mesh.nodes(); ++n) {
    const double* at = mesh.point(n);
    const double* below = mesh.point(n % rows.lines);
    if (at[0] != below[0] || at[1] != below[1]) return false;
    if (at[2] != rows.height[std::size_t(n / rows.lines)]) return false;
  }
  return std::ranges::is_sorted(rows.height, std::ranges::less_equal{});
}

/// Every row of elements repeats the lowest.
bool repeats_cells(const Mesh<3>& mesh, int lines, std::size_t of_row) {
  for (std::size_t i = 0; i < mesh.element_node.size(); ++i) {
    const int shift = static_cast<int>(i / of_row) * lines;
    if (mesh.element_node[i] != mesh.element_node[i % of_row] + shift) return false;
  }
  return true;
}

}  // namespace

std::optional<Extrusion> extrusion_of(const Mesh<3>& mesh) {
  constexpr int corners = 8;
  if (mesh.nodes_per_element != corners || mesh.nodes() == 0) return std::nullopt;
  Extrusion found;
  const double bottom = mesh.point(0)[2];
  while (found.lines < mesh.nodes() && mesh.point(found.lines)[2] == bottom) ++found.lines;
  const int rows = mesh.nodes() / found.lines;
  if (rows < 2 || rows * found.lines != mesh.nodes() || mesh.elements() % (rows - 1) != 0)
    return std::nullopt;
  for (int row = 0; row < rows; ++row) found.height.push_back(mesh.point(row * found.lines)[2]);
  const std::size_t of_row = mesh.element_node.size() / std::size_t(rows - 1);
  if (!stands_upright(mesh, found) || !repeats_cells(mesh, found.lines, of_row))
    return std::nullopt;
  for (std::size_t i = 0; i < of_row; ++i) {
    if (mesh.element_node[i] < found.lines) found.cell.push_back(mesh.element_node[i]);
  }
  if (found.cell.size() * 2 != of_row) return std::nullopt;
  return found;
}

}  // namespace dccast::mesh
