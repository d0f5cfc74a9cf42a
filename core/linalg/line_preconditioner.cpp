#include "core/linalg/line_preconditioner.hpp"

#include <algorithm>

namespace dccast::linalg {

LinePreconditioner::LinePreconditioner(const SparsityPattern& pattern, int lines)
    : lines_(std::size_t(lines)),
      inverse_pivot_(std::size_t(pattern.unknowns())),
      below_(std::size_t(pattern.unknowns())) {
  const std::vector<int>&start = pattern.column_start(), &row = pattern.row();
  for (int n = 0; n + lines < pattern.unknowns(); ++n) {
    const auto first = row.begin() + start[std::size_t(n)];
    const auto end = row.begin() + start[std::size_t(n) + 1];
    above_.push_back(static_cast<int>(std::lower_bound(first, end, n + lines) - row.begin()));
  }
}

bool LinePreconditioner::factorize(const SparsityPattern& pattern, std::span<const double> values) {
  bool positive = true;
  // Tridiagonal factorisation of each vertical line; node n stands on node n - lines.
  for (std::size_t n = 0; n < inverse_pivot_.size(); ++n) {
    double pivot = values[std::size_t(pattern.diagonal(static_cast<int>(n)))];
    if (n >= lines_) {
      const double coupling = values[std::size_t(above_[n - lines_])];
      below_[n] = coupling * inverse_pivot_[n - lines_];
      pivot -= below_[n] * coupling;
    }

    positive = positive && pivot > 0.0;
    inverse_pivot_[n] = 1.0 / pivot;
  }
  return positive;
}

void LinePreconditioner::apply(std::span<const double> r, std::span<double> z) const {
  // Forward substitution, upwards.
  std::copy_n(r.begin(), lines_, z.begin());
  for (std::size_t n = lines_; n < z.size(); ++n) z[n] = r[n] - below_[n] * z[n - lines_];

  // Backward substitution, downwards.
  for (std::size_t n = z.size(); n-- > 0;) {
    z[n] *= inverse_pivot_[n];
    if (n + lines_ < z.size()) z[n] -= below_[n + lines_] * z[n + lines_];
  }
}

}  // namespace dccast::linalg
