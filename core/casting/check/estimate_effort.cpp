#include "core/casting/check/checks.hpp"

#include <algorithm>
#include <cmath>

#include "core/mesh/slab_mesh.hpp"

namespace dccast::casting {

namespace {

// Seconds on one core of a server of 2023, fitted to the cases of docs/validity.md: within a factor
// of 1.5 on the shipped cases and on refinement 2 with newton, and on steps halved and quartered
// with the cells. Fits, not theory: the cost of a step goes with the nodes times those of a row,
// the band of the matrix.
constexpr double heat_by_node = 0.5e-6;       // [s]
constexpr double heat_by_band = 26e-9;        // [s]
constexpr double mechanics_by_band = 142e-9;  // [s] newton, at steps of `usual_step`
constexpr double usual_step = 0.7;            // [s]
constexpr double ring_factor = 4.0;           // a billet's steps need more iterations
constexpr double memory_base = 3e7;           // [bytes]
constexpr double memory_by_node = 1.2e4;      // [bytes]

/// Of a mechanical step against newton's.
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

struct Size {
  double nodes = 0.0;  ///< mean over the run
  double band = 0.0;   ///< nodes times those of a row
};

Size mean_size(const CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  Size size;
  if (!s.file.empty()) {
    size.nodes = static_cast<double>(found.estimate.nodes);
    size.band = size.nodes * std::sqrt(size.nodes);
    return size;
  }
  const double row = s.columns * s.refinement + 1.0;
  const double at_start = row * (s.rows * s.refinement + 1.0);
  size.nodes = 0.5 * (at_start + static_cast<double>(found.estimate.nodes));
  size.band = size.nodes * row;
  return size;
}

/// Shorter steps need fewer iterations.
double step_factor(const CaseFindings& found) {
  const Case& c = found.casting;
  const double moves = c.time.end - std::max(c.mechanics.start, -c.schedule.hold);
  const double mean_step = moves / static_cast<double>(found.mechanical_steps);
  return std::clamp(std::sqrt(mean_step / usual_step), 0.3, 2.0);
}

}  // namespace

void estimate_effort(CaseFindings& found) {
  const Case& c = found.casting;
  const Size size = mean_size(found);
  const double heat =
      c.thermal.file.empty() ? heat_by_node * size.nodes + heat_by_band * size.band : 0.0;
  double mechanics = 0.0;
  if (found.mechanical_steps > 0) {
    mechanics = mechanics_by_band * size.band * algorithm_factor(c) * step_factor(found);
    if (found.axisymmetric()) mechanics *= ring_factor;
  }
  const double rounds = c.coupling.gap_feedback ? c.coupling.iterations : 1.0;
  found.estimate.solver_seconds = static_cast<double>(found.estimate.steps) * heat +
                                  rounds * static_cast<double>(found.mechanical_steps) *
                                      (mechanics + (rounds - 1.0) / rounds * heat);
  found.estimate.memory_bytes =
      memory_base + memory_by_node * static_cast<double>(found.estimate.nodes);
}

}  // namespace dccast::casting
