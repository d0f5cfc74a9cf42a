#include "core/mechanics/constrained_system.hpp"

#include <algorithm>

namespace dccast::mechanics {

namespace {
/// Share of a factorisation [1] that costs as much as the solves of a condensation.
constexpr double cheap_share = 0.1;
/// More iterations of conjugate gradients than this are slower than a factorisation.
constexpr int most_gradients = 25;
/// Ten times what the two-grid solver usually needs: if it is exceeded, the step itself is unsound.
constexpr int most_gradients_of_grids = 400;
}  // namespace

void ConstrainedSystem::lift(std::span<const double> stiffness,
                             std::span<const double> step_of_fixed) {
  lifting_ =
      std::any_of(step_of_fixed.begin(), step_of_fixed.end(), [](double d) { return d != 0.0; });
  if (lifting_) linalg::multiply(*pattern_, stiffness, step_of_fixed, work_->lifted);
}

bool ConstrainedSystem::factorize(std::span<const char> fixed,
                                  std::span<const double> step_of_fixed) {
  lift(work_->stiffness, step_of_fixed);
  work_->unheld_stiffness.swap(work_->stiffness);
  return hold_and_factorize(fixed);
}

bool ConstrainedSystem::hold_and_factorize(std::span<const char> fixed) {
  const Stopwatch watch(work_->cost.preconditioner);
  auto& values = work_->stiffness;
  values = work_->unheld_stiffness;

  const auto& start = pattern_->column_start();
  const auto& row = pattern_->row();
  for (std::size_t c = 0; c + 1 < start.size(); ++c) {
    const std::size_t diagonal = std::size_t(start[c]);
    for (std::size_t k = diagonal + 1; k < std::size_t(start[c + 1]); ++k) {
      if (fixed[c] != 0 || fixed[std::size_t(row[k])] != 0) values[k] = 0.0;
    }
    // The diagonal keeps its own value, so that the pivots have the scale of their neighbourhood.
    if (fixed[c] != 0 && !(values[diagonal] > 0.0)) values[diagonal] = 1.0;
  }

  held_.assign(fixed.begin(), fixed.end());
  work_->secants.clear();
  renewed_ = false;
  factor_is_exact_ = work_->two_grid == nullptr;

  if (!factor_is_exact_) return work_->two_grid->factorize(*pattern_, values, fixed);
  condensation_.start(*pattern_, work_->unheld_stiffness, work_->solver, fixed);
  return work_->solver.factorize(values);
}

bool ConstrainedSystem::changes_only_last_rows(std::span<const char> fixed) const {
  for (std::size_t u = 0; u < fixed.size(); ++u) {
    if ((fixed[u] != 0) == (held_[u] != 0)) continue;
    if (work_->solver.share_to_repeat(static_cast<int>(u)) > cheap_share) return false;
  }
  return true;
}

bool ConstrainedSystem::change(std::span<const char> fixed, std::span<const double> step_of_fixed) {
  work_->secants.clear();
  const bool done = work_->is_solid                 ? change_solid(fixed)
                    : changes_only_last_rows(fixed) ? hold_and_factorize(fixed)
                                                    : condensation_.change(fixed);
  if (done) lift(work_->unheld_stiffness, step_of_fixed);
  return done;
}

bool ConstrainedSystem::change_solid(std::span<const char> fixed) {
  if (work_->two_grid != nullptr) return true;
  const bool same = std::ranges::equal(fixed, held_);
  if (!renewed_ && !same && changes_only_last_rows(fixed)) return hold_and_factorize(fixed);
  factor_is_exact_ = same && !renewed_;
  return true;
}

bool ConstrainedSystem::renew(std::span<const char> fixed, std::span<const double> step_of_fixed) {
  if (!work_->is_solid) return false;
  work_->unheld_stiffness.swap(work_->stiffness);
  renewed_ = true;
  return change(fixed, step_of_fixed);
}

bool ConstrainedSystem::solve_free(std::span<const char> fixed, double tolerance) {
  auto& d = work_->direction;
  if (!work_->is_solid || factor_is_exact_) {
    condensation_.solve(d, d);
    return true;
  }

  const bool by_grids = work_->two_grid != nullptr;
  const auto precondition = [&](std::span<const double> r, std::span<double> z) {
    by_grids ? work_->two_grid->apply(r, z) : work_->solver.solve(r, z);
  };

  work_->lifted = d;
  const auto outcome =
      gradients_.solve(*pattern_, work_->unheld_stiffness, fixed, precondition, work_->lifted, d,
                       {tolerance, by_grids ? most_gradients_of_grids : most_gradients});
  work_->gradient_iterations += outcome.iterations;
  if (outcome.end == linalg::CgOutcome::End::converged) return true;
  if (by_grids || !hold_and_factorize(fixed)) return false;
  condensation_.solve(work_->lifted, d);
  return true;
}

void ConstrainedSystem::learn(std::span<const char> fixed, double length) {
  auto &step = work_->direction, &change = work_->last_residual;
  for (std::size_t i = 0; i < step.size(); ++i) {
    const bool free = fixed[i] == 0;
    step[i] = free ? length * step[i] : 0.0;
    change[i] = free ? work_->residual[i] - change[i] : 0.0;
  }
  work_->secants.add(step, change);
}

bool ConstrainedSystem::solve(std::span<const char> fixed, std::span<const double> step_of_fixed,
                              double tolerance) {
  const Stopwatch watch(work_->cost.solution);
  auto& d = work_->direction;
  for (std::size_t i = 0; i < d.size(); ++i) {
    d[i] = fixed[i] != 0 ? 0.0 : -work_->residual[i] - (lifting_ ? work_->lifted[i] : 0.0);
  }
  work_->secants.before_solution(d);
  const bool solved = solve_free(fixed, tolerance);
  work_->secants.after_solution(d);
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (fixed[i] != 0) d[i] = step_of_fixed[i];
  }
  lifting_ = false;
  return solved;
}

}  // namespace dccast::mechanics
