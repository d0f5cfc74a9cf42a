#include "core/linalg/direct_solver.hpp"

#include <utility>

#include "core/linalg/sweep_order.hpp"

namespace dccast::linalg {

bool band_wins(double flops, int unknowns, const TileKernels& kernels) {
  return flops <= kernels.flops_per_unknown * unknowns;
}

void DirectSolver::analyze(const SparsityPattern& pattern, Geometry geometry,
                           std::span<const std::vector<int>> fronts) {
  std::vector<int> place = reversed_order(pattern.unknowns());
  BandShape shape(pattern, place);
  for (const auto& front : fronts) {
    std::vector<int> other = sweep_order(pattern, front);
    BandShape its(pattern, other);
    if (its.flops >= shape.flops) continue;
    place = std::move(other);
    shape = std::move(its);
  }
  uses_band_ = band_wins(shape.flops, pattern.unknowns(), best_tile_kernels());
  if (uses_band_) {
    band_.analyze(pattern, place, std::move(shape));
  } else {
    cholmod_.analyze(pattern, geometry);
  }
}

bool DirectSolver::factorize(std::span<const double> values) {
  ++factorizations_;
  return uses_band_ ? band_.factorize(values) : cholmod_.factorize(values);
}

void DirectSolver::solve(std::span<const double> b, std::span<double> x) {
  ++solves_;
  uses_band_ ? band_.solve(b, x) : cholmod_.solve(b, x);
}

double DirectSolver::factor_entries() const {
  return uses_band_ ? band_.factor_entries() : cholmod_.factor_entries();
}

}  // namespace dccast::linalg
