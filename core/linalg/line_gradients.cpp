#include "core/linalg/line_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/instructions.hpp"

namespace dccast::linalg {

namespace {

/// Diagonals on one side of the matrix of a plan of columns and layers: of the 27 nodes around a
/// node, 13 have a higher number.
constexpr std::size_t most_diagonals = 13;

/// Components of a product that are computed together, so that they stay in the fastest cache.
constexpr std::size_t components_together = 1024;

/// Differences of row and column of the entries below the diagonal, ascending; empty if there are
/// more than the plan of an extruded mesh has.
std::vector<int> offsets_of(const SparsityPattern& pattern) {
  std::vector<int> offsets;
  const std::vector<int>& start = pattern.column_start();
  for (int c = 0; c < pattern.unknowns(); ++c) {
    for (int k = start[std::size_t(c)] + 1; k < start[std::size_t(c) + 1]; ++k) {
      const int offset = pattern.row()[std::size_t(k)] - c;
      const auto place = std::ranges::lower_bound(offsets, offset);
      if (place != offsets.end() && *place == offset) continue;
      if (offsets.size() == most_diagonals) return {};
      offsets.insert(place, offset);
    }
  }
  return offsets;
}

/// Sum of products, by independent sums that share registers.
double dot(const std::vector<float>& a, const std::vector<float>& b) {
  constexpr std::size_t sums = 64;
  float sum[sums] = {};
  std::size_t i = 0;
  for (; i + sums <= a.size(); i += sums) {
    for (std::size_t k = 0; k < sums; ++k) sum[k] += a[i + k] * b[i + k];
  }
  for (; i < a.size(); ++i) sum[0] += a[i] * b[i];
  return std::accumulate(sum, sum + sums, 0.0);
}

}  // namespace

bool LineGradients::suits(const SparsityPattern& pattern) {
  return !offsets_of(pattern).empty();
}

LineGradients::LineGradients(const SparsityPattern& pattern, int lines)
    : unknowns_(std::size_t(pattern.unknowns())),
      lines_(std::size_t(lines)),
      offset_(offsets_of(pattern)),
      place_(pattern.entries()),
      diagonal_(unknowns_),
      coupling_(offset_.size() * unknowns_, 0.0F),
      pivot_(unknowns_),
      inverse_pivot_(unknowns_),
      below_(unknowns_, 0.0F) {
  for (auto* vector : {&solution_, &residual_, &preconditioned_, &direction_, &product_})
    vector->assign(unknowns_, 0.0F);

  const std::vector<int>& start = pattern.column_start();
  for (int n = 0; n < pattern.unknowns(); ++n) {
    for (int k = start[std::size_t(n)] + 1; k < start[std::size_t(n) + 1]; ++k) {
      const int offset = pattern.row()[std::size_t(k)] - n;
      const auto diagonal = std::ranges::lower_bound(offset_, offset) - offset_.begin();
      place_[std::size_t(k)] = std::size_t(diagonal) * unknowns_ + std::size_t(n);
      if (offset == lines) above_.push_back(k);
    }
  }
}

bool LineGradients::factorize(const SparsityPattern& pattern, std::span<const double> values,
                              std::span<const char> held) {
  const std::vector<int>& start = pattern.column_start();
  // Held unknowns are coupled to nothing: their components of all vectors remain zero.
  for (std::size_t n = 0; n < unknowns_; ++n) {
    const std::size_t own = std::size_t(start[n]);
    diagonal_[n] = held[n] != 0 ? 1.0F : static_cast<float>(values[own]);
    for (std::size_t k = own + 1; k < std::size_t(start[n + 1]); ++k) {
      const bool free = held[n] == 0 && held[std::size_t(pattern.row()[k])] == 0;
      coupling_[place_[k]] = free ? static_cast<float>(values[k]) : 0.0F;
    }
  }
  return factorize_lines(pattern, values, held);
}

/// Tridiagonal factorisation of each vertical line; node n stands on node n - lines.
bool LineGradients::factorize_lines(const SparsityPattern& pattern, std::span<const double> values,
                                    std::span<const char> held) {
  bool positive = true;
  for (std::size_t n = 0; n < unknowns_; ++n) {
    const bool free = held[n] == 0;
    double pivot = free ? values[std::size_t(pattern.diagonal(static_cast<int>(n)))] : 1.0;
    if (n >= lines_) {
      const std::size_t under = n - lines_;
      const double coupling = free && held[under] == 0 ? values[std::size_t(above_[under])] : 0.0;
      const double share = coupling / pivot_[under];
      pivot -= share * coupling;
      below_[n] = static_cast<float>(share);
    }

    positive = positive && pivot > 0.0;
    pivot_[n] = pivot;
    inverse_pivot_[n] = static_cast<float>(1.0 / pivot);
  }
  return positive;
}

void LineGradients::solve_lines() {
  const float *const r = residual_.data(), *const below = below_.data(),
                     *const inverse = inverse_pivot_.data();
  float* const z = preconditioned_.data();

  // Forward substitution, row by row upwards.
  std::copy_n(r, lines_, z);
  for (std::size_t row = lines_; row < unknowns_; row += lines_) {
    for (std::size_t i = 0; i < lines_; ++i)
      z[row + i] = r[row + i] - below[row + i] * z[row - lines_ + i];
  }

  // Backward substitution, row by row downwards.
  for (std::size_t i = unknowns_ - lines_; i < unknowns_; ++i) z[i] *= inverse[i];
  for (std::size_t row = unknowns_ - lines_; row > 0; row -= lines_) {
    for (std::size_t i = 0; i < lines_; ++i) {
      const std::size_t n = row - lines_ + i;
      z[n] = z[n] * inverse[n] - below[row + i] * z[row + i];
    }
  }
}

void LineGradients::multiply() {
  for (std::size_t first = 0; first < unknowns_; first += components_together)
    multiply(first, std::min(first + components_together, unknowns_));
}

void LineGradients::multiply(std::size_t first, std::size_t end) {
  const float* const x = direction_.data();
  float* const y = product_.data();
  for (std::size_t i = first; i < end; ++i) y[i] = diagonal_[i] * x[i];

  for (std::size_t d = 0; d < offset_.size(); ++d) {
    const std::size_t apart = std::size_t(offset_[d]);
    const float* const coupling = &coupling_[d * unknowns_];
    // With the node of the higher number, then with the one of the lower number.
    const std::size_t last = std::min(end, unknowns_ - apart);
    for (std::size_t i = first; i < last; ++i) y[i] += coupling[i] * x[i + apart];
    for (std::size_t i = std::max(first, apart); i < end; ++i)
      y[i] += coupling[i - apart] * x[i - apart];
  }
}

CgOutcome LineGradients::iterate(const ConjugateGradients::Limits& limits) {
  CgOutcome outcome;
  outcome.residual = 1.0;
  double previous_energy = 1.0;

  // The negated comparison lets a residual that is not a number enter the loop; it ends as
  // indefinite there.
  while (!(outcome.residual <= limits.tolerance)) {
    outcome.end = CgOutcome::End::too_many;
    if (outcome.iterations == limits.iterations) break;

    // New direction, conjugate to the previous ones.
    solve_lines();
    const double energy = dot(residual_, preconditioned_);
    const float share =
        outcome.iterations == 0 ? 0.0F : static_cast<float>(energy / previous_energy);
    for (std::size_t i = 0; i < unknowns_; ++i)
      direction_[i] = preconditioned_[i] + share * direction_[i];

    // Step length that minimises the energy along the direction.
    multiply();
    const double stiffness = dot(direction_, product_);
    outcome.end = CgOutcome::End::indefinite;
    if (!(energy > 0.0 && stiffness > 0.0 && std::isfinite(stiffness))) break;

    const float length = static_cast<float>(energy / stiffness);
    for (std::size_t i = 0; i < unknowns_; ++i) {
      solution_[i] += length * direction_[i];
      residual_[i] -= length * product_[i];
    }
    previous_energy = energy;

    ++outcome.iterations;
    outcome.residual = std::sqrt(dot(residual_, residual_));
    outcome.end = CgOutcome::End::converged;
  }
  return outcome;
}

CgOutcome LineGradients::solve(std::span<const double> b, std::span<double> x,
                               const ConjugateGradients::Limits& limits) {
  std::ranges::fill(solution_, 0.0F);
  const double scale = std::sqrt(std::inner_product(b.begin(), b.end(), b.begin(), 0.0));
  if (scale == 0.0) {
    std::ranges::fill(x, 0.0);
    return {};
  }

  // With a right-hand side of norm one nothing overflows or vanishes in single precision.
  for (std::size_t i = 0; i < unknowns_; ++i) residual_[i] = static_cast<float>(b[i] / scale);
  CgOutcome outcome;
  with_lanes([&]<int>() { outcome = iterate(limits); });
  for (std::size_t i = 0; i < unknowns_; ++i) x[i] = scale * double(solution_[i]);
  return outcome;
}

}  // namespace dccast::linalg
