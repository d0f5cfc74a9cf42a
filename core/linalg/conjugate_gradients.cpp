#include "core/linalg/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::linalg {

namespace {

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// y <- y + factor x
void add(double factor, const std::vector<double>& x, std::vector<double>& y) {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
}

}  // namespace

void ConjugateGradients::mask(std::span<const char> held, std::vector<double>& v) const {
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (held[i] != 0) v[i] = 0.0;
  }
}

void ConjugateGradients::start(std::span<const double> b, std::span<const char> held) {
  residual_.assign(b.begin(), b.end());
  mask(held, residual_);
  solution_.assign(b.size(), 0.0);
  direction_.assign(b.size(), 0.0);
  preconditioned_.resize(b.size());
  product_.resize(b.size());
}

CgOutcome ConjugateGradients::solve(const SparsityPattern& pattern, std::span<const double> values,
                                    std::span<const char> held, const Preconditioner& precondition,
                                    std::span<const double> b, std::span<double> x,
                                    const Limits& limits) {
  start(b, held);

  const double right_norm = std::sqrt(dot(residual_, residual_));
  CgOutcome outcome;
  outcome.residual = right_norm > 0.0 ? 1.0 : 0.0;
  double previous_energy = 1.0;

  // The negated comparison lets a residual that is not a number enter the loop; it ends as
  // indefinite there.
  while (!(outcome.residual <= limits.tolerance)) {
    outcome.end = CgOutcome::End::too_many;
    if (outcome.iterations == limits.iterations) break;

    // New direction, conjugate to the previous ones.
    precondition(residual_, preconditioned_);
    mask(held, preconditioned_);
    const double energy = dot(residual_, preconditioned_);
    const double share = outcome.iterations == 0 ? 0.0 : energy / previous_energy;
    for (std::size_t i = 0; i < direction_.size(); ++i) {
      direction_[i] = preconditioned_[i] + share * direction_[i];
    }

    // Step length that minimises the energy along the direction.
    multiply(pattern, values, direction_, product_);
    mask(held, product_);
    const double stiffness = dot(direction_, product_);
    outcome.end = CgOutcome::End::indefinite;
    if (!(energy > 0.0 && stiffness > 0.0 && std::isfinite(stiffness))) break;

    add(energy / stiffness, direction_, solution_);
    add(-energy / stiffness, product_, residual_);
    previous_energy = energy;

    ++outcome.iterations;
    outcome.residual = std::sqrt(dot(residual_, residual_)) / right_norm;
    outcome.end = CgOutcome::End::converged;
  }

  std::copy(solution_.begin(), solution_.end(), x.begin());
  return outcome;
}

}  // namespace dccast::linalg
