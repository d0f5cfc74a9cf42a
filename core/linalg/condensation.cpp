#include "core/linalg/condensation.hpp"

#include <algorithm>

namespace dccast::linalg {

namespace {
constexpr double rounding = 1e-13;  // of a difference, relative to what is subtracted
}  // namespace

void Condensation::start(const SparsityPattern& pattern, std::span<const double> values,
                         DirectSolver& solver, std::span<const char> held) {
  pattern_ = &pattern;
  values_ = values;
  solver_ = &solver;
  base_.assign(held.begin(), held.end());
  held_ = base_;
  changed_.clear();
}

Condensation::Changed Condensation::condense(int unknown, bool released) {
  const std::size_t size = base_.size();
  Changed change{unknown, released, std::vector<double>(size, 0.0), std::vector<double>(size)};

  // A released unknown brings its column of the matrix; a held one brings a unit column.
  if (released) {
    unit_.assign(size, 0.0);
    unit_[std::size_t(unknown)] = 1.0;
    multiply(*pattern_, values_, unit_, change.column);
  } else {
    change.column[std::size_t(unknown)] = 1.0;
  }

  for (std::size_t i = 0; i < size; ++i) right_[i] = base_[i] != 0 ? 0.0 : change.column[i];
  solver_->solve(right_, change.solved);
  return change;
}

bool Condensation::few_differ(std::span<const char> held) const {
  std::size_t changes = 0;
  for (std::size_t i = 0; i < base_.size(); ++i) {
    if ((held[i] != 0) != (base_[i] != 0)) ++changes;
  }
  return changes <= most_changes_;
}

bool Condensation::change(std::span<const char> held) {
  if (!few_differ(held)) return false;
  std::vector<Changed> changed;
  right_.resize(base_.size());

  // Newly held unknowns come first; a change that was there before keeps its column.
  for (const bool released : {false, true}) {
    for (std::size_t i = 0; i < base_.size(); ++i) {
      if ((held[i] != 0) == (base_[i] != 0) || (base_[i] != 0) != released) continue;
      const auto known = std::find_if(changed_.begin(), changed_.end(), [&](const Changed& c) {
        return c.unknown == static_cast<int>(i);
      });
      changed.push_back(known != changed_.end() ? std::move(*known)
                                                : condense(static_cast<int>(i), released));
    }
  }

  changed_ = std::move(changed);
  held_.assign(held.begin(), held.end());
  return factorize_small();
}

double Condensation::along(const Changed& changed, std::span<const double> on_free) const {
  if (!changed.released) return on_free[std::size_t(changed.unknown)];
  double sum = 0.0;
  for (std::size_t i = 0; i < on_free.size(); ++i) sum += changed.column[i] * on_free[i];
  return sum;
}

/// L D L' without pivoting, which a quasi-definite matrix has in any order. Its pivots are negative
/// for the newly held and positive for the released unknowns exactly when the matrix of the free
/// unknowns is positive definite.
bool Condensation::factorize_small() {
  const std::size_t n = changed_.size();
  small_.assign(n * n, 0.0);

  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c <= r; ++c) {
      const bool both = changed_[r].released && changed_[c].released;
      double entry = both ? changed_[r].column[std::size_t(changed_[c].unknown)] : 0.0;
      entry -= along(changed_[r], changed_[c].solved);

      for (std::size_t k = 0; k < c; ++k) {
        entry -= small_[r * n + k] * small_[k * n + k] * small_[c * n + k];
      }
      small_[r * n + c] = r == c ? entry : entry / small_[c * n + c];
    }

    // Remaining stiffness of a released unknown; below rounding error it counts as zero.
    const double pivot = small_[r * n + r];
    const double least = changed_[r].released
                             ? rounding * changed_[r].column[std::size_t(changed_[r].unknown)]
                             : 0.0;
    if (!(changed_[r].released ? pivot > least : pivot < 0.0)) return false;
  }
  return true;
}

void Condensation::solve_small(std::vector<double>& z) const {
  const std::size_t n = changed_.size();
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t k = 0; k < r; ++k) z[r] -= small_[r * n + k] * z[k];
  }
  for (std::size_t r = n; r-- > 0;) {
    z[r] /= small_[r * n + r];
    for (std::size_t k = r + 1; k < n; ++k) z[r] -= small_[k * n + r] * z[k];
  }
}

void Condensation::solve(std::span<const double> b, std::span<double> x) {
  const std::size_t n = changed_.size();
  // Right-hand side of the small system: b on the released unknowns minus the part of the free
  // ones.
  std::vector<double> z(n, 0.0);
  for (std::size_t c = 0; c < n; ++c) {
    if (changed_[c].released) z[c] = b[std::size_t(changed_[c].unknown)];
  }

  right_.resize(base_.size());
  for (std::size_t i = 0; i < right_.size(); ++i) right_[i] = base_[i] != 0 ? 0.0 : b[i];
  solver_->solve(right_, x);
  for (std::size_t c = 0; c < n; ++c) z[c] -= along(changed_[c], x);
  solve_small(z);

  // x_f = K_ff^-1 b_f - W z
  for (std::size_t c = 0; c < n; ++c) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] -= z[c] * changed_[c].solved[i];
  }

  for (std::size_t c = 0; c < n; ++c) {
    if (changed_[c].released) x[std::size_t(changed_[c].unknown)] = z[c];
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (held_[i] != 0) x[i] = 0.0;
  }
}

}  // namespace dccast::linalg
