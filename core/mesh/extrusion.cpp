#include "core/mesh/extrusion.hpp"

#include <algorithm>

namespace dccast::mesh {

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
