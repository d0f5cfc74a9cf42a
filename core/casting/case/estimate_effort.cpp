#include <algorithm>
#include <cmath>

#include "core/casting/case/checks.hpp"
#include "core/mesh/plan_file.hpp"

namespace dccast::casting {

namespace {

// Seconds on one core of a server of 2023, fitted to the cases of docs/developers/decisions.md:
// within a factor of 1.5 on the shipped cases. Fits, not theory: the cost of a step goes with the
// nodes times those of a row, the band of the matrix.
constexpr double heat_by_node = 0.3e-6;      // [s]
constexpr double heat_by_band = 16e-9;       // [s]
constexpr double mechanics_by_band = 82e-9;  // [s] newton, at steps of `usual_step`
constexpr double usual_step = 0.7;           // [s]
constexpr double billet_factor = 6.9;        // a billet's steps need more iterations
constexpr double memory_base = 3e7;          // [bytes]
constexpr double memory_by_node = 1.2e4;     // [bytes]

// Quarter slab of bricks: the factor for 3 unknowns per node in a nested dissection, measured from
// 5,000 to 192,000 unknowns, plus states and matrices.
constexpr double solid_memory_by_node = 3.5e4;  // [bytes]
constexpr double factor_bytes = 143e6;          // [bytes] of `factor_unknowns`
constexpr double factor_seconds = 0.25;         // [s]
constexpr double factor_unknowns = 20.6e3;
constexpr double factor_memory_power = 1.28;
constexpr double factor_time_power = 1.75;
constexpr double solid_heat_by_node = 1.5e-6;       // [s]
constexpr double solid_heat_memory_by_node = 5e3;   // [bytes] of a node that only the heat has
constexpr double solid_mechanics_by_node = 1.8e-5;  // [s] iterations of newton without the factor
// Iterations of a step: where metal also yields they are twice as many as where it only creeps.
constexpr double yielding_factor = 1.33, creeping_factor = 0.63;

// The same with the two-grid solver instead of the factor: peak memory of whole processes from
// 6,000 to 97,000 nodes was 13 to 17 kB per node, the time of a step 40 to 60 us per node
// (docs/developers/factorisation.md).
constexpr double grids_memory_by_node = 1.8e4;  // [bytes]
constexpr double grids_seconds_by_node = 5e-5;  // [s] a mechanical step
constexpr double memory_before_grids = 1.5e8;   // [bytes] of the largest factor before the switch

/// Cost of a mechanical step relative to newton.
double algorithm_factor(const Case& c) {
  const bool p1 = c.section.element == mesh::ElementKind::p1;
  switch (c.mechanics.options.algorithm) {
    case mechanics::Algorithm::newton:
      return 1.0;
    case mechanics::Algorithm::vnbm:
      return p1 ? 3.7 : 5.5;
    case mechanics::Algorithm::nbm:
      return p1 ? 3.4 : 5.5;
    case mechanics::Algorithm::sbm:
      return 117.0;
  }
  return 1.0;
}

/// Of the nodes of the heat, those that the mechanics has too [1].
double mechanics_share(const CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  if (s.kind != mesh::SectionKind::quarter_slab || !s.file.empty()) return 1.0;
  const double columns = s.columns * s.refinement, layers = s.layers * s.refinement;
  return (columns + 1.0) * (layers + 1.0) / static_cast<double>(found.nodes_per_row);
}

/// Number of nodes of the heat, mean over the run.
double mean_nodes(const CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  const auto at_end = static_cast<double>(found.estimate.nodes);
  if (mesh::has_mesh_file(s)) return at_end;
  return 0.5 * (static_cast<double>(found.nodes_per_row) * (s.rows * s.refinement + 1.0) + at_end);
}

/// Shorter steps need fewer iterations.
double step_factor(const CaseFindings& found) {
  const Case& c = found.casting;
  const double moves = c.time.end - std::max(c.mechanics.start, -c.schedule.hold);
  const double mean_step = moves / static_cast<double>(found.mechanical_steps);
  return std::clamp(std::sqrt(mean_step / usual_step), 0.3, 2.0);
}

/// Seconds of a heat step and of a mechanical step.
struct StepSeconds {
  double heat = 0.0;
  double mechanics = 0.0;
};

StepSeconds in_a_section(const CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  const double nodes = mean_nodes(found);
  const double band = nodes * (mesh::has_mesh_file(s) ? std::sqrt(nodes)
                                                      : static_cast<double>(found.nodes_per_row));
  StepSeconds seconds{heat_by_node * nodes + heat_by_band * band, 0.0};
  if (found.mechanical_steps == 0) return seconds;
  seconds.mechanics = mechanics_by_band * band * step_factor(found);
  if (found.axisymmetric()) seconds.mechanics *= billet_factor;
  return seconds;
}

/// Whether a mesh with this number of nodes is solved by two grids.
bool by_two_grids(const CaseFindings& found, double nodes) {
  const Case& c = found.casting;
  const bool lines = !mesh::has_mesh_file(c.section) && c.section.element != mesh::ElementKind::p1;
  return lines && c.mechanics.options.algorithm == mechanics::Algorithm::newton &&
         3.0 * nodes >= c.mechanics.options.two_grids_from_unknowns;
}

StepSeconds in_a_solid(const CaseFindings& found) {
  const double heat_nodes = mean_nodes(found);
  StepSeconds seconds{solid_heat_by_node * heat_nodes, 0.0};
  if (found.mechanical_steps == 0) return seconds;
  const double nodes = mechanics_share(found) * heat_nodes;
  const double factor = factor_seconds * std::pow(3.0 * nodes / factor_unknowns, factor_time_power);
  seconds.mechanics = by_two_grids(found, nodes) ? grids_seconds_by_node * nodes
                                                 : factor + solid_mechanics_by_node * nodes;
  seconds.mechanics *=
      found.casting.alloy.cold_strength.has_value() ? yielding_factor : creeping_factor;
  return seconds;
}

double memory(const CaseFindings& found) {
  const auto all_nodes = static_cast<double>(found.estimate.nodes);
  if (!found.solid()) return memory_base + memory_by_node * all_nodes;

  const double nodes = mechanics_share(found) * all_nodes;
  const double of_heat = solid_heat_memory_by_node * (all_nodes - nodes);
  if (by_two_grids(found, nodes))
    return std::max(memory_base + grids_memory_by_node * nodes, memory_before_grids) + of_heat;
  const double factor = factor_bytes * std::pow(3.0 * nodes / factor_unknowns, factor_memory_power);
  return memory_base + solid_memory_by_node * nodes + factor + of_heat;
}

}  // namespace

void estimate_effort(CaseFindings& found) {
  const Case& c = found.casting;
  const StepSeconds step = found.solid() ? in_a_solid(found) : in_a_section(found);
  const double heat = c.thermal.file.empty() ? step.heat : 0.0;
  const double mechanics = step.mechanics * algorithm_factor(c);
  const double rounds = c.coupling.gap_feedback ? c.coupling.iterations : 1.0;
  found.estimate.solver_seconds = static_cast<double>(found.estimate.steps) * heat +
                                  rounds * static_cast<double>(found.mechanical_steps) *
                                      (mechanics + (rounds - 1.0) / rounds * heat);
  found.estimate.memory_bytes = memory(found);
}

}  // namespace dccast::casting
