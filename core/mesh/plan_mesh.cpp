#include "core/mesh/plan_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "core/mesh/extrusion.hpp"

namespace dccast::mesh {

namespace {

/// The nodes of a cell in the order of CellDivision: those of its base, then those above them.
template <int Dim>
std::array<int, CellDivision<Dim>::corners> cell_corners(const Base<Dim>& base, int cell, int row) {
  std::array<int, CellDivision<Dim>::corners> node;
  constexpr std::size_t half = std::size_t(Base<Dim>::nodes_per_cell);
  for (std::size_t k = 0; k < half; ++k) {
    const int below = row * base.nodes() + base.cell_node[std::size_t(cell) * half + k];
    node[k] = below;
    node[half + k] = below + base.nodes();
  }
  return node;
}

/// A part of the surface of a cell. @param first_element  of the cell
template <int Dim>
Facet<Dim> make_facet(const typename CellDivision<Dim>::Part& part,
                      const std::array<int, CellDivision<Dim>::corners>& node, int first_element) {
  Facet<Dim> facet;
  facet.nodes = static_cast<int>(part.corner.size());
  facet.element = first_element + part.element;
  for (std::size_t k = 0; k < part.corner.size(); ++k)
    facet.node[k] = node[std::size_t(part.corner[k])];
  return facet;
}

}  // namespace

template <int Dim>
PlanMesh<Dim>::PlanMesh(Base<Dim> base, ElementKind kind, double flat_from)
    : base_(std::move(base)), kind_(kind), flat_from_(flat_from) {}

template <int Dim>
int PlanMesh<Dim>::elements_per_row() const {
  return base_.cells() * static_cast<int>(cell_division<Dim>(kind_).elements.size());
}

template <int Dim>
void PlanMesh<Dim>::build(std::span<const double> heights) {
  mesh_ = Mesh<Dim>{};
  mesh_.nodes_per_element = static_cast<int>(cell_division<Dim>(kind_).elements.front().size());
  for (const auto& wall : base_.walls)
    mesh_.patches.push_back({wall.name, wall.kind, wall.normal, {}});

  for (std::size_t row = 0; row < heights.size(); ++row)
    place_row_of_nodes(static_cast<int>(row), heights[row]);
  for (int row = 0; row < rows(); ++row) add_row_of_cells(row);
  set_bottom();
  set_top();
}

template <int Dim>
void PlanMesh<Dim>::raise(std::span<const double> heights) {
  const int old_top = rows(), top = static_cast<int>(heights.size()) - 1;
  for (int row = old_top; row <= top; ++row) place_row_of_nodes(row, heights[std::size_t(row)]);
  for (int row = old_top; row < top; ++row) add_row_of_cells(row);
  if (top > old_top) set_top();
}

template <int Dim>
void PlanMesh<Dim>::place_row_of_nodes(int row, double height) {
  const std::size_t nodes = std::size_t(base_.nodes()), first = std::size_t(row) * nodes;
  if (mesh_.node.size() < Dim * (first + nodes)) mesh_.node.resize(Dim * (first + nodes));
  // Over a bowl the row sinks by a share of the block's depth.
  const double sinking = base_.depth.empty() ? 0.0 : std::max(0.0, 1.0 - height / flat_from_);
  for (std::size_t i = 0; i < nodes; ++i) {
    double* x = mesh_.node.data() + Dim * (first + i);
    for (std::size_t d = 0; d + 1 < Dim; ++d) x[d] = base_.node[i * (Dim - 1) + d];
    x[Dim - 1] = base_.depth.empty() ? height : height - sinking * base_.depth[i];
  }
}

template <int Dim>
void PlanMesh<Dim>::add_row_of_cells(int row) {
  for (int cell = 0; cell < base_.cells(); ++cell) {
    const auto node = cell_corners(base_, cell, row);
    for (const auto& element : cell_division<Dim>(kind_).elements)
      for (const int corner : element) mesh_.element_node.push_back(node[std::size_t(corner)]);
  }
  add_walls(row);
}

template <int Dim>
void PlanMesh<Dim>::add_walls(int row) {
  const auto& division = cell_division<Dim>(kind_);
  const int per_cell = static_cast<int>(division.elements.size());
  const int first_element = row * elements_per_row();
  for (std::size_t w = 0; w < base_.walls.size(); ++w) {
    for (const auto& piece : base_.walls[w].pieces) {
      const auto node = cell_corners(base_, piece.cell, row);
      for (const auto& part : division.side[std::size_t(piece.side)])
        mesh_.patches[w].facets.push_back(
            make_facet<Dim>(part, node, first_element + per_cell * piece.cell));
    }
  }
}

template <int Dim>
void PlanMesh<Dim>::set_bottom() {
  const auto& division = cell_division<Dim>(kind_);
  const int per_cell = static_cast<int>(division.elements.size());
  auto& facets = mesh_.facets(PatchKind::bottom);
  for (int cell = 0; cell < base_.cells(); ++cell)
    for (const auto& part : division.bottom)
      facets.push_back(make_facet<Dim>(part, cell_corners(base_, cell, 0), per_cell * cell));
}

template <int Dim>
void PlanMesh<Dim>::set_top() {
  const auto& division = cell_division<Dim>(kind_);
  const int per_cell = static_cast<int>(division.elements.size()), row = rows() - 1;
  auto& facets = mesh_.facets(PatchKind::top);
  facets.clear();
  for (int cell = base_.cells() - 1; cell >= 0; --cell)
    for (const auto& part : division.top)
      facets.push_back(make_facet<Dim>(part, cell_corners(base_, cell, row),
                                       row * elements_per_row() + per_cell * cell));
}

template class PlanMesh<2>;
template class PlanMesh<3>;

}  // namespace dccast::mesh
