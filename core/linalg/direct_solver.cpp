#include "core/linalg/direct_solver.hpp"

#include <cmath>
#include <utility>

namespace dccast::linalg {

namespace {

// Measured for a quarter slab in hexahedra on one core: docs/developers/factorisation.md, "In three
// dimensions".
constexpr double solves_per_factor = 20.0;  // with one factor per step
constexpr double solve_bytes_rate = 6e9;    // [byte/s] of factor in a solve by either method
constexpr double reference_size = 13e3;     // unknowns of the fits below
constexpr double cholmod_factor_s = 0.13;   // grows with exponent 1.63
constexpr double cholmod_bytes = 48e6;      // grows with exponent 1.35

double cholmod_seconds(int unknowns) {
  const double size = unknowns / reference_size;
  const double solve = cholmod_bytes * std::pow(size, 1.35) / solve_bytes_rate;
  return cholmod_factor_s * std::pow(size, 1.63) + solves_per_factor * solve;
}

double band_seconds(const BandShape& shape, const TileKernels& kernels) {
  const double bytes = static_cast<double>(shape.start.back()) * sizeof(Tile);
  return shape.flops / kernels.flops_per_second + solves_per_factor * bytes / solve_bytes_rate;
}

/// Measured rule: whether a band factorisation is faster than CHOLMOD's. In 2D it assumes one solve
/// per factorisation, for a solid the twenty of its conjugate gradients.
/// @param shape  of the band in the best order known
bool band_wins(const BandShape& shape, int unknowns, Geometry geometry,
               const TileKernels& kernels) {
  if (geometry == Geometry::solid) return band_seconds(shape, kernels) < cholmod_seconds(unknowns);
  return shape.flops <= kernels.flops_per_unknown * unknowns;
}

}  // namespace

void DirectSolver::analyze(const SparsityPattern& pattern, Geometry geometry,
                           std::span<const std::vector<int>> fronts) {
  // The order that gives the band the least work.
  std::vector<int> place = reversed_order(pattern.unknowns());
  BandShape shape(pattern, place);
  for (const auto& front : fronts) {
    std::vector<int> swept = sweep_order(pattern, front);
    BandShape swept_shape(pattern, swept);
    if (swept_shape.flops >= shape.flops) continue;
    place = std::move(swept);
    shape = std::move(swept_shape);
  }

  const bool by_band = band_wins(shape, pattern.unknowns(), geometry, best_tile_kernels());
  method_ = by_band ? Method::band : Method::cholmod;
  if (by_band) return band_.analyze(pattern, place, std::move(shape));
  cholmod_.analyze(pattern, geometry);
}

bool DirectSolver::factorize(std::span<const double> values) {
  ++factorizations_;
  return with_solver(*this, [&](auto& solver) { return solver.factorize(values); });
}

void DirectSolver::solve(std::span<const double> b, std::span<double> x) {
  ++solves_;
  with_solver(*this, [&](auto& solver) { solver.solve(b, x); });
}

double DirectSolver::factor_entries() const {
  return with_solver(*this, [](const auto& solver) { return solver.factor_entries(); });
}

std::size_t DirectSolver::memory_bytes() const {
  return with_solver(*this, [](const auto& solver) { return solver.memory_bytes(); });
}

}  // namespace dccast::linalg
