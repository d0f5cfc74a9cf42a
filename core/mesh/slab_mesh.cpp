#include "core/mesh/slab_mesh.hpp"

#include "core/mesh/graded_cells.hpp"

namespace dccast::mesh {

namespace {

std::vector<double> initial_rows(const SectionSpec& spec) {
  return refined(ends_of_cells(graded_cells(spec.initial_depth, spec.rows, spec.bottom_cell),
                               spec.initial_depth),
                 spec.refinement);
}

RowMerging merging_of(const SectionSpec& spec) {
  return {spec.merging.below, spec.merging.largest_cell / spec.refinement};
}

}  // namespace

double growth_cell(const SectionSpec& spec) {
  if (spec.growth_cell) return *spec.growth_cell / spec.refinement;
  const std::vector<double> rows = initial_rows(spec);
  return rows.back() - rows[rows.size() - 2];
}

template <int Dim>
SlabMesh<Dim>::SlabMesh(const SectionSpec& spec)
    : ExtrudedMesh<Dim>(base_of<Dim>(spec), spec.element, initial_rows(spec), growth_cell(spec),
                        merging_of(spec)) {}

int rows_at(const SectionSpec& spec, double level) {
  return rows_at_level(initial_rows(spec), growth_cell(spec), merging_of(spec), level);
}

template class SlabMesh<2>;
template class SlabMesh<3>;

}  // namespace dccast::mesh
