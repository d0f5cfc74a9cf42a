#include "core/mesh/extrusion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dccast::mesh {

namespace {

/// Sum of 1 + r + ... + r^(n-1) with r = exp(log_ratio), without cancellation near r = 1.
double geometric_sum(double log_ratio, int terms) {
  return log_ratio == 0.0 ? terms : std::expm1(terms * log_ratio) / std::expm1(log_ratio);
}

/// Whether every row of nodes stands vertically above the lowest one.
bool has_vertical_lines(const Mesh<3>& mesh, const Extrusion& rows) {
  for (int n = 0; n < mesh.nodes(); ++n) {
    const double* node = mesh.point(n);
    const double* below = mesh.point(n % rows.lines);
    if (node[0] != below[0] || node[1] != below[1]) return false;
    if (node[2] != rows.height[std::size_t(n / rows.lines)]) return false;
  }
  return std::ranges::is_sorted(rows.height, std::ranges::less_equal{});
}

/// Whether every row of elements repeats the lowest one.
/// @param row_size  node numbers in a row of elements
bool repeats_cells(const Mesh<3>& mesh, int lines, std::size_t row_size) {
  for (std::size_t i = 0; i < mesh.element_node.size(); ++i) {
    const int shift = static_cast<int>(i / row_size) * lines;
    if (mesh.element_node[i] != mesh.element_node[i % row_size] + shift) return false;
  }
  return true;
}

}  // namespace

std::vector<double> graded_cells(double length, int cells, double first) {
  // The length is monotone in the ratio, so that bisection on its logarithm always finds it.
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
  std::vector<double> end{0.0};
  for (const double width : widths) end.push_back(end.back() + width);
  end.back() = length;  // without the rounding error of the sum: patches must close
  return end;
}

std::vector<double> refined(const std::vector<double>& position, int refinement) {
  std::vector<double> fine{position.front()};
  for (std::size_t i = 1; i < position.size(); ++i) {
    const double begin = position[i - 1], end = position[i];
    for (int k = 1; k < refinement; ++k) fine.push_back(begin + (end - begin) * k / refinement);
    fine.push_back(end);
  }
  return fine;
}

// Corners in 2D: 0 and 1 below, 2 above 0, 3 above 1. In 3D: 0 to 3 below, 4 to 7 above them.

template <>
const CellDivision<2>& cell_division<2>(ElementKind kind) {
  static const CellDivision<2> whole{
      {{0, 1, 3, 2}}, {{{0, 1}, 0}}, {{{3, 2}, 0}}, {{{{2, 0}, 0}}, {{{1, 3}, 0}}}};
  static const CellDivision<2> triangles{
      {{0, 1, 3}, {0, 3, 2}}, {{{0, 1}, 0}}, {{{3, 2}, 1}}, {{{{2, 0}, 1}}, {{{1, 3}, 0}}}};
  return kind == ElementKind::p1 ? triangles : whole;
}

template <>
const CellDivision<3>& cell_division<3>(ElementKind kind) {
  static const CellDivision<3> whole{
      {{0, 1, 2, 3, 4, 5, 6, 7}},
      {{{0, 3, 2, 1}, 0}},
      {{{4, 5, 6, 7}, 0}},
      {{{{0, 1, 5, 4}, 0}}, {{{1, 2, 6, 5}, 0}}, {{{2, 3, 7, 6}, 0}}, {{{3, 0, 4, 7}, 0}}}};

  // Six around the diagonal from 0 to 6. Every face is cut from its corner nearest to 0 to the
  // opposite one, so that cells whose base starts at the same corner fit together.
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

std::optional<Extrusion> extrusion_of(const Mesh<3>& mesh) {
  constexpr int corners = 8;
  if (mesh.nodes_per_element != corners || mesh.nodes() == 0) return std::nullopt;

  // The lowest row ends at the first node above it.
  Extrusion found;
  const double bottom = mesh.point(0)[2];
  while (found.lines < mesh.nodes() && mesh.point(found.lines)[2] == bottom) ++found.lines;
  const int rows = mesh.nodes() / found.lines;
  if (rows < 2 || rows * found.lines != mesh.nodes() || mesh.elements() % (rows - 1) != 0)
    return std::nullopt;
  for (int row = 0; row < rows; ++row) found.height.push_back(mesh.point(row * found.lines)[2]);

  const std::size_t row_size = mesh.element_node.size() / std::size_t(rows - 1);
  if (!has_vertical_lines(mesh, found) || !repeats_cells(mesh, found.lines, row_size))
    return std::nullopt;

  // The lower half of the nodes of the lowest elements.
  for (std::size_t i = 0; i < row_size; ++i) {
    if (mesh.element_node[i] < found.lines) found.cell.push_back(mesh.element_node[i]);
  }
  if (found.cell.size() * 2 != row_size) return std::nullopt;
  return found;
}

}  // namespace dccast::mesh
