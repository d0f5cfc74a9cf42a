#include "core/linalg/line_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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

std::optional<LineGradients> LineGradients::of(const SparsityPattern& pattern, int lines) {
  std::vector<int> offsets = offsets_of(pattern);
  if (offsets.empty()) return std::nullopt;
  return LineGradients(pattern, lines, std::move(offsets));
}

LineGradients::LineGradients(const SparsityPattern& pattern, int lines, std::vector<int> offset)
    : unknowns_(std::size_t(pattern.unknowns())),
      lines_(std::size_t(lines)),
      offset_(std::move(offset)),
      place_(pattern.entries()),
      diagonal_(unknowns_),
      coupling_(offset_.size() * unknowns_, 0.0F),
      pivot_(unknowns_),
      inverse_pivot_(unknowns_),
      below_(unknowns_, 0.0F) {
  for (auto* vector : {&vectors_.solution, &vectors_.residual, &vectors_.preconditioned,
                       &vectors_.direction, &vectors_.product})
    vector->assign(unknowns_, 0.0F);

  const std::vector<int>& start = pattern.column_start();
  for (int n = 0; n < pattern.unknowns(); ++n) {
    for (int k = start[std::size_t(n)] + 1; k < start[std::size_t(n) + 1]; ++k) {
      const int apart = pattern.row()[std::size_t(k)] - n;
      const auto diagonal = std::ranges::lower_bound(offset_, apart) - offset_.begin();
      place_[std::size_t(k)] = std::size_t(diagonal) * unknowns_ + std::size_t(n);
      if (apart == lines) above_.push_back(k);
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
  const float *const r = vectors_.residual.data(), *const below = below_.data(),
                     *const inverse = inverse_pivot_.data();
  float* const z = vectors_.preconditioned.data();

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
  const float* const x = vectors_.direction.data();
  float* const y = vectors_.product.data();
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

CgOutcome LineGradients::solve(std::span<const double> b, std::span<double> x,
                               const ConjugateGradients::Limits& limits) {
  // With a right-hand side of norm one nothing overflows or vanishes in single precision.
  const double scale = std::sqrt(std::inner_product(b.begin(), b.end(), b.begin(), 0.0));
  const double norm = scale != 0.0 ? 1.0 : 0.0;
  for (std::size_t i = 0; i < unknowns_; ++i)
    vectors_.residual[i] = scale != 0.0 ? static_cast<float>(b[i] / scale) : 0.0F;

  CgOutcome outcome;
  with_lanes([&]<int>() {
    outcome = iterate_gradients(
        vectors_, norm, [this] { solve_lines(); }, [this] { multiply(); },
        [](const Vector& a, const Vector& c) { return dot(a, c); }, limits);
  });
  for (std::size_t i = 0; i < unknowns_; ++i) x[i] = scale * double(vectors_.solution[i]);
  return outcome;
}

}  // namespace dccast::linalg
