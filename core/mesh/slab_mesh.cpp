#include "core/mesh/slab_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/mesh/extrusion.hpp"

namespace dccast::mesh {

namespace {

constexpr double divide_above = 1.5;   // height of the top row [growth cells]
constexpr std::size_t first_rows = 2;  // of cells, at the begin of filling

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

/// Heights of the initial rows of nodes [m].
std::vector<double> initial_rows(const SectionSpec& spec) {
  return refined(ends_of_cells(graded_cells(spec.initial_depth, spec.rows, spec.bottom_cell),
                               spec.initial_depth),
                 spec.refinement);
}

/// The criteria of a section, with the cell of its refinement.
RowMerging refined_merging(const SectionSpec& spec) {
  return {spec.merging.below, spec.merging.largest_cell / spec.refinement};
}

/// Row of nodes below the rows added by growth. The topmost initial row of cells belongs to these:
/// it becomes a growth cell when the first row is inserted.
int first_grown(const std::vector<double>& row_heights) {
  return static_cast<int>(row_heights.size()) - 2;
}

}  // namespace

template <int Dim>
SlabMesh<Dim>::SlabMesh(const SectionSpec& spec)
    : base_(base_of<Dim>(spec)),
      kind_(spec.element),
      growth_cell_(growth_cell(spec)),
      merging_(refined_merging(spec)),
      plan_(initial_rows(spec)),
      first_grown_(first_grown(plan_)),
      heights_(plan_) {
  build();
}

template <int Dim>
void SlabMesh<Dim>::start_filling() {
  heights_.resize(std::min(heights_.size(), first_rows + 1));
  build();
}

template <int Dim>
int SlabMesh<Dim>::elements_per_row() const {
  return base_.cells() * static_cast<int>(cell_division<Dim>(kind_).elements.size());
}

template <int Dim>
void SlabMesh<Dim>::build() {
  mesh_ = Mesh<Dim>{};
  mesh_.nodes_per_element = static_cast<int>(cell_division<Dim>(kind_).elements.front().size());
  for (const auto& wall : base_.walls)
    mesh_.patches.push_back({wall.name, wall.kind, wall.normal, {}});

  for (int row = 0; row <= rows(); ++row) place_row_of_nodes(row);
  for (int row = 0; row < rows(); ++row) add_row_of_cells(row);
  set_bottom();
  set_top();
}

template <int Dim>
void SlabMesh<Dim>::place_row_of_nodes(int row) {
  const std::size_t nodes = std::size_t(base_.nodes()), first = std::size_t(row) * nodes;
  if (mesh_.node.size() < Dim * (first + nodes)) mesh_.node.resize(Dim * (first + nodes));
  for (std::size_t i = 0; i < nodes; ++i) {
    double* x = mesh_.node.data() + Dim * (first + i);
    for (std::size_t d = 0; d + 1 < Dim; ++d) x[d] = base_.node[i * (Dim - 1) + d];
    x[Dim - 1] = heights_[std::size_t(row)];
  }
}

template <int Dim>
void SlabMesh<Dim>::add_row_of_cells(int row) {
  for (int cell = 0; cell < base_.cells(); ++cell) {
    const auto node = cell_corners(base_, cell, row);
    for (const auto& element : cell_division<Dim>(kind_).elements)
      for (const int corner : element) mesh_.element_node.push_back(node[std::size_t(corner)]);
  }
  add_walls(row);
}

template <int Dim>
void SlabMesh<Dim>::add_walls(int row) {
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
void SlabMesh<Dim>::set_bottom() {
  const auto& division = cell_division<Dim>(kind_);
  const int per_cell = static_cast<int>(division.elements.size());
  auto& facets = mesh_.facets(PatchKind::bottom);
  for (int cell = 0; cell < base_.cells(); ++cell)
    for (const auto& part : division.bottom)
      facets.push_back(make_facet<Dim>(part, cell_corners(base_, cell, 0), per_cell * cell));
}

template <int Dim>
void SlabMesh<Dim>::set_top() {
  const auto& division = cell_division<Dim>(kind_);
  const int per_cell = static_cast<int>(division.elements.size()), row = rows() - 1;
  auto& facets = mesh_.facets(PatchKind::top);
  facets.clear();
  for (int cell = base_.cells() - 1; cell >= 0; --cell)
    for (const auto& part : division.top)
      facets.push_back(make_facet<Dim>(part, cell_corners(base_, cell, row),
                                       row * elements_per_row() + per_cell * cell));
}

template <int Dim>
void SlabMesh<Dim>::divide_top_row(double height, std::vector<double>& inserted) {
  const double level = heights_.back();
  heights_.back() = height;
  heights_.push_back(level);
  inserted.push_back(height);
}

template <int Dim>
std::vector<double> SlabMesh<Dim>::grow_to(double level) {
  if (level < heights_.back()) throw std::logic_error("SlabMesh: the metal level cannot sink");

  std::vector<double> inserted;
  const bool filling = heights_.back() < plan_.back();
  heights_.back() = level;

  // While the mould is filled, rows are inserted at their planned heights.
  const auto next_is_due = [&] {
    const std::size_t next = heights_.size() - 1;
    if (next + 1 >= plan_.size()) return false;
    return level >= plan_.back() ||
           level - plan_[next] > (divide_above - 1.0) * (plan_[next + 1] - plan_[next]);
  };
  while (filling && next_is_due()) divide_top_row(plan_[heights_.size() - 1], inserted);

  while (level > plan_.back() &&
         level - heights_[heights_.size() - 2] > divide_above * growth_cell_)
    divide_top_row(heights_[heights_.size() - 2] + growth_cell_, inserted);

  const int last_old_row = rows() - static_cast<int>(inserted.size());
  for (int row = last_old_row; row <= rows(); ++row) place_row_of_nodes(row);
  for (int row = last_old_row; row < rows(); ++row) add_row_of_cells(row);
  if (!inserted.empty()) set_top();
  return inserted;
}

template <int Dim>
MergedRows SlabMesh<Dim>::rows_to_merge() const {
  return {heights_, mesh::rows_to_merge(heights_, first_grown_, merging_),
          std::size_t(nodes_per_row()), std::size_t(elements_per_row())};
}

template <int Dim>
void SlabMesh<Dim>::merge(const MergedRows& rows) {
  take_out_rows(rows, 1, heights_);
  build();
}

template <int Dim>
void SlabMesh<Dim>::restore(const std::vector<double>& row_heights) {
  heights_ = row_heights;
  build();
}

int rows_at(const SectionSpec& spec, double level) {
  std::vector<double> heights = initial_rows(spec);
  const int first = first_grown(heights);
  const double grown = growth_cell(spec);

  while (level - heights[heights.size() - 2] > divide_above * grown * (1.0 + 1e-9)) {
    heights.back() = heights[heights.size() - 2] + grown;
    heights.push_back(heights.back() + grown);

    const MergedRows merged{heights, rows_to_merge(heights, first, refined_merging(spec)), 1, 1};
    if (!merged.empty()) take_out_rows(merged, 1, heights);
  }
  return static_cast<int>(heights.size()) - 1;
}

template class SlabMesh<2>;
template class SlabMesh<3>;

double growth_cell(const SectionSpec& spec) {
  if (spec.growth_cell) return *spec.growth_cell / spec.refinement;
  const std::vector<double> rows = initial_rows(spec);
  return rows.back() - rows[rows.size() - 2];
}

}  // namespace dccast::mesh
