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

/// Lowest row of nodes that is flat over the block's bowl, 0 without one: at least as high as the
/// bowl is deep, so that no cell is more than twice as high over the bowl as over the lip. The row
/// of cells that stretches with the metal level always lies above it.
std::size_t first_flat_row(const SectionSpec& spec, const std::vector<double>& rows) {
  if (!spec.bowl) return 0;
  const auto high_enough = std::ranges::lower_bound(rows, spec.bowl->depth);
  return std::min(std::size_t(high_enough - rows.begin()), rows.size() - 2);
}

/// Its height [m].
double flat_from(const SectionSpec& spec) {
  const std::vector<double> rows = initial_rows(spec);
  return rows[first_flat_row(spec, rows)];
}

}  // namespace

template <int Dim>
SlabMesh<Dim>::SlabMesh(const SectionSpec& spec) : SlabMesh(spec, base_of<Dim>(spec)) {
  if (spec.heat_cells.per_column * spec.heat_cells.per_layer == 1) return;
  heat_.emplace(base_of<Dim>(spec, Plan::heat), spec.element, flat_from(spec));
  heat_->build(heights_);
}

template <int Dim>
SlabMesh<Dim>::SlabMesh(const SectionSpec& spec, Base<Dim> base)
    : mechanics_(std::move(base), spec.element, flat_from(spec)),
      growth_cell_(growth_cell(spec)),
      merging_(refined_merging(spec)),
      plan_(initial_rows(spec)),
      first_grown_(first_grown(plan_)),
      first_flat_(first_flat_row(spec, plan_)),
      heights_(plan_) {
  build();
}

template <int Dim>
void SlabMesh<Dim>::build() {
  mechanics_.build(heights_);
  if (heat_) heat_->build(heights_);
}

template <int Dim>
void SlabMesh<Dim>::start_filling() {
  const std::size_t rows = std::max(first_rows, first_flat_ + 1);
  heights_.resize(std::min(heights_.size(), rows + 1));
  build();
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

  mechanics_.raise(heights_);
  if (heat_) heat_->raise(heights_);
  return inserted;
}

template <int Dim>
MergedRows SlabMesh<Dim>::rows_to_merge() const {
  return {heights_, mesh::rows_to_merge(heights_, first_grown_, merging_),
          std::size_t(mechanics_.nodes_per_row()), std::size_t(mechanics_.elements_per_row())};
}

template <int Dim>
MergedRows SlabMesh<Dim>::of_heat(MergedRows rows) const {
  rows.nodes_per_row = std::size_t(heat().nodes_per_row());
  rows.elements_per_row = std::size_t(heat().elements_per_row());
  return rows;
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

double unmerged_rows(const SectionSpec& spec, double level) {
  const std::vector<double> heights = initial_rows(spec);
  const double below_top = heights[heights.size() - 2];
  return double(heights.size()) - 2.0 + (level - below_top) / growth_cell(spec);
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
