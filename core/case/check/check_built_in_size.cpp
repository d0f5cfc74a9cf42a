#include "core/case/check/checks.hpp"

#include "core/mesh/slab_mesh.hpp"

namespace dccast::casting {

void too_many_nodes(CaseFindings& found, double nodes) {
  found.fault(
      "mesh.columns", std::to_string(found.casting.section.columns),
      "leads to " + with_unit(nodes, "nodes at the end"),
      "at most limits.maximum_nodes = " + std::to_string(found.casting.limits.maximum_nodes),
      "use fewer or larger cells, or raise the limit");
}

void check_built_in_size(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  if (!found.sound(grid_keys) || !found.sound(course_keys)) return;
  const double cell = s.growth_cell.value_or(s.initial_depth / s.rows) / s.refinement;
  // Nodes and cells of a row of the plan.
  const double across = found.solid() ? s.layers * s.refinement + 1.0 : 1.0;
  // Checked before any mesh is built: a growth cell of micrometres would exhaust the memory.
  const double rough = (s.rows * s.refinement + (*found.final_level - s.initial_depth) / cell) *
                       (s.columns * s.refinement + 1.0) * across;
  if (rough > 2.0 * static_cast<double>(found.casting.limits.maximum_nodes))
    return too_many_nodes(found, rough);
  const std::int64_t rows = mesh::rows_at(s, *found.final_level);
  const std::int64_t columns = std::int64_t(s.columns) * s.refinement;
  const std::int64_t layers = found.solid() ? std::int64_t(s.layers) * s.refinement : 1;
  const std::int64_t in_a_cell = s.element != mesh::ElementKind::p1 ? 1 : found.solid() ? 6 : 2;
  found.estimate.nodes = (rows + 1) * (columns + 1) * (found.solid() ? layers + 1 : 1);
  found.estimate.elements = rows * columns * layers * in_a_cell;
  if (found.estimate.nodes > found.casting.limits.maximum_nodes) {
    too_many_nodes(found, static_cast<double>(found.estimate.nodes));
  }
  estimate_effort(found);
}

}  // namespace dccast::casting
