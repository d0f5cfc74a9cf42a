#include "core/linalg/secant_updates.hpp"

#include <algorithm>
#include <numeric>

namespace dccast::linalg {

namespace {

double product(std::span<const double> a, std::span<const double> b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// a += factor b
void add_multiple(double factor, std::span<const double> b, std::span<double> a) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += factor * b[i];
}

}  // namespace

void SecantUpdates::resize(std::size_t unknowns) {
  unknowns_ = unknowns;
  pairs_ = 0;
  steps_.assign(most * unknowns, 0.0);
  changes_.assign(most * unknowns, 0.0);
}

std::span<const double> SecantUpdates::step(std::size_t pair) const {
  return std::span(steps_).subspan(pair * unknowns_, unknowns_);
}

std::span<const double> SecantUpdates::change(std::size_t pair) const {
  return std::span(changes_).subspan(pair * unknowns_, unknowns_);
}

void SecantUpdates::add(std::span<const double> step, std::span<const double> change) {
  const double work = product(step, change);
  if (!(work > 0.0)) return;

  const auto first = std::ptrdiff_t(pairs_ * unknowns_);
  std::ranges::copy(step, steps_.begin() + first);
  std::ranges::copy(change, changes_.begin() + first);
  work_[pairs_++] = work;
}

void SecantUpdates::before_solution(std::span<double> b) {
  for (std::size_t k = pairs_; k-- > 0;) {
    share_[k] = product(step(k), b) / work_[k];
    add_multiple(-share_[k], change(k), b);
  }
}

void SecantUpdates::after_solution(std::span<double> x) const {
  for (std::size_t k = 0; k < pairs_; ++k)
    add_multiple(share_[k] - product(change(k), x) / work_[k], step(k), x);
}

}  // namespace dccast::linalg
