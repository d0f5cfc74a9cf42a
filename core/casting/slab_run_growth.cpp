// Updates of a run after changes of its mesh: inserted rows and merged rows.
#include <utility>

#include "core/base/stopwatch.hpp"
#include "core/casting/slab_run.hpp"
#include "core/findings/motion.hpp"

namespace dccast::casting {

template <int Dim>
bool SlabRun<Dim>::grow(double level, double temperature,
                        std::optional<thermal::MetalEntry>& entry) {
  if (!mesh_.grows() || level <= mesh_.slab().level()) return false;
  mesh::SlabMesh<Dim>& slab = mesh_.slab();
  const int first_moved = slab.elements_per_row() * (slab.rows() - 1);
  slab.grow_to(level);
  {
    const Stopwatch watch(heat_seconds_);
    entry = heat_.follow_growth(state_.heat, slab.nodes_per_row(), temperature);
  }
  mechanics_.follow_growth(state_.slab, slab.mesh(), slab.nodes_per_row(), first_moved);
  state_.row_heights = slab.row_heights();
  return true;
}

template <int Dim>
MergeOutcome SlabRun<Dim>::merge_rows() {
  MergeOutcome outcome;
  if (!mesh_.grows()) return outcome;
  const mesh::MergedRows merged = mesh_.slab().rows_to_merge();
  if (merged.empty()) return outcome;
  outcome.rows = static_cast<int>(merged.taken_out.size());
  auto projected = mechanics_.projected(state_.slab, merged, state_.heat.temperature);
  mesh_.slab().merge(merged);
  {
    const Stopwatch watch(heat_seconds_);
    outcome.energy_error = heat_.follow_merging(state_.heat, merged);
  }
  outcome.mechanics = mechanics_.follow_merging(state_.slab, std::move(projected), mesh_.mesh(),
                                                state_.heat.temperature);
  merge_turns<Dim>(merged, state_.findings.history.when_liquid);
  state_.row_heights = mesh_.slab().row_heights();
  return outcome;
}

template bool SlabRun<2>::grow(double, double, std::optional<thermal::MetalEntry>&);
template bool SlabRun<3>::grow(double, double, std::optional<thermal::MetalEntry>&);
template MergeOutcome SlabRun<2>::merge_rows();
template MergeOutcome SlabRun<3>::merge_rows();

}  // namespace dccast::casting
