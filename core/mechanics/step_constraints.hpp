#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// Signorini's conditions at the nodes of the bottom and of walls, enforced by a primal-dual active
/// set (Hintermueller, Ito, Kunisch 2002): gap >= 0, reaction >= 0, one of them zero.
///
/// A pair in the set is held at zero gap, and its reaction results from the solution; a pair
/// outside carries no force, and its gap results from the solution. The generalised Newton method
/// of the paper's section 4.3.1 with eps_c -> 0 is this iteration (Lemma 5).
class ActiveSet {
public:
  /// Violations below these count as none.
  struct Tolerance {
    double gap;    ///< [m] penetration that counts as zero
    double force;  ///< [N/m] tensile force that counts as zero; scaled to the weight, not to
                   ///< thermal forces
  };

  ActiveSet() = default;
  /// @param carrying  number of pairs, from the first, of which at least one must be closed
  ActiveSet(std::vector<char> active, std::size_t carrying)
      : active_(std::move(active)), carrying_(carrying) {}
  explicit ActiveSet(std::vector<char> active) : active_(std::move(active)) {
    carrying_ = active_.size();
  }

  const std::vector<char>& active() const { return active_; }
  bool active(std::size_t pair) const { return active_[pair] != 0; }

  /// Opens or closes the pairs that violate their condition. The carrying pairs are never all
  /// opened: a slab without any support has no equilibrium.
  /// @param gap         (pair) [m]
  /// @param reaction    (pair) [N/m], meaningful for active pairs only
  /// @param one_by_one  change only the worst violator, so that two pairs cannot keep switching
  ///                    each other
  /// @return number of pairs that changed
  int update(std::span<const double> gap, std::span<const double> reaction,
             const Tolerance& tolerance, bool one_by_one);

private:
  /// (pair) not zero: closed.
  std::vector<char> active_;
  /// Number of pairs, from the first, of which at least one must be closed.
  std::size_t carrying_ = 0;
};

/// Largest violation of gap >= 0 [m], reaction >= 0 [N/m] and of the complementarity of the two
/// [1], relative to the scales of length [m] and force [N/m].
double complementarity_error(std::span<const double> gap, std::span<const double> reaction,
                             double length_scale, double force_scale);

/// The held unknowns of a step: those fixed by the problem and those closed by the contact set.
/// Used by every algorithm that treats contact by an active set.
///
/// Units: displacements `u`, `direction` [m]; residuals and forces [N/m] in 2D, [N/rad] if
/// axisymmetric, [N] in 3D.
template <int Dim>
class StepConstraints {
public:
  /// @param active     by contact unknown; initial contact set, replaced by the final one in
  ///                   store()
  /// @param round_off  round_off_force() of the problem: the accuracy of a reaction
  StepConstraints(const StepProblem<Dim>& problem, std::vector<char>& active, double round_off)
      : problem_(&problem),
        active_(&active),
        set_(active, problem.carrying()),
        gap_(problem.contact.size()),
        reaction_(problem.contact.size()),
        force_tolerance_(std::max(force_share_of_weight * problem.weight, round_off)) {
    mark();
  }

  std::span<const char> fixed() const { return fixed_; }

  /// Displacement that the held unknowns still need to reach their targets [m].
  std::span<const double> step_from(std::span<const double> u) {
    step_.assign(u.size(), 0.0);
    for (std::size_t i = 0; i < problem_->contact.size(); ++i) {
      const std::size_t unknown = std::size_t(problem_->contact[i]);
      if (set_.active(i)) step_[unknown] = problem_->closed_at(i) - u[unknown];
    }
    for (std::size_t i = 0; i < u.size(); ++i) {
      // Fixed unknowns come last: what the problem holds wins over the contact set.
      if (problem_->fixed[i] != 0) step_[i] = problem_->target[i] - u[i];
    }
    return step_;
  }

  /// Norm of the residual on the free unknowns [N/m].
  double norm_of_free(std::span<const double> residual) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < residual.size(); ++i) {
      if (fixed_[i] == 0) sum += residual[i] * residual[i];
    }
    return std::sqrt(sum);
  }

  /// Opens and closes pairs. @return number of pairs that changed
  int update(std::span<const double> u, std::span<const double> residual, bool one_by_one) {
    if (problem_->contact.empty()) return 0;
    collect(u, residual);
    const ActiveSet::Tolerance tolerance{gap_tolerance, force_tolerance_};
    const int changes = set_.update(gap_, reaction_, tolerance, one_by_one);
    if (changes > 0) mark();
    return changes;
  }

  void store() { *active_ = set_.active(); }

  /// Closes every pair that penetrates. @return number of pairs closed
  int close_penetrating(std::span<const double> u) {
    return close_where([&](std::size_t pair) { return problem_->normal_gap(pair, u) < 0.0; });
  }

  /// Step length along a direction at which the first open pair closes, at most `length` [1,
  /// relative to the direction].
  double feasible_length(std::span<const double> u, std::span<const double> direction,
                         double length) const {
    for (std::size_t i = 0; i < problem_->contact.size(); ++i) {
      const double opening = problem_->along_gap(i, direction);
      if (set_.active(i) || opening >= 0.0) continue;
      const double gap = std::max(0.0, problem_->normal_gap(i, u));
      length = std::min(length, gap / -opening);
    }
    return length;
  }

  /// Closes the open pairs that are at the block and move towards it.
  int close_blocking(std::span<const double> u, std::span<const double> direction) {
    return close_where([&](std::size_t pair) {
      return problem_->normal_gap(pair, u) <= gap_tolerance &&
             problem_->along_gap(pair, direction) < 0.0;
    });
  }

  /// Opens the closed pairs under tension: all of them, or the one with the largest tension.
  int release(std::span<const double> u, std::span<const double> residual, bool only_one) {
    collect(u, residual);
    // The step length takes care of the gaps, so this call must not close any pair.
    const ActiveSet::Tolerance tolerance{INFINITY, force_tolerance_};
    const int changes = set_.update(gap_, reaction_, tolerance, only_one);
    if (changes > 0) mark();
    return changes;
  }

  /// Relative violation of the contact conditions [1]; lengths relative to 1 mm, forces to the
  /// weight.
  double complementarity_error(std::span<const double> u, std::span<const double> residual) {
    if (problem_->contact.empty()) return 0.0;
    collect(u, residual);
    constexpr double length_scale = 1e-3;
    return mechanics::complementarity_error(gap_, reaction_, length_scale,
                                            std::max(problem_->weight, 1e-30));
  }

private:
  static constexpr double gap_tolerance = 1e-10;  // [m]
  static constexpr double force_share_of_weight = 1e-6;

  /// Gaps [m] of all pairs, and reactions of the closed ones [N/m in 2D].
  void collect(std::span<const double> u, std::span<const double> residual) {
    for (std::size_t i = 0; i < gap_.size(); ++i) {
      gap_[i] = problem_->normal_gap(i, u);
      reaction_[i] = set_.active(i) ? problem_->along_gap(i, residual) : 0.0;
    }
  }
  /// Closes the open pairs for which condition(pair) holds. @return number of pairs closed
  template <class Condition>
  int close_where(Condition&& condition) {
    std::vector<char> active = set_.active();
    int changes = 0;
    for (std::size_t i = 0; i < active.size(); ++i) {
      if (active[i] != 0 || !condition(i)) continue;
      active[i] = 1;
      ++changes;
    }
    if (changes > 0) {
      set_ = ActiveSet(std::move(active), problem_->carrying());
      mark();
    }
    return changes;
  }
  /// Combines the unknowns held by the problem with those of closed pairs.
  void mark() {
    fixed_ = problem_->fixed;
    for (std::size_t i = 0; i < problem_->contact.size(); ++i) {
      if (set_.active(i)) fixed_[std::size_t(problem_->contact[i])] = 1;
    }
  }

  const StepProblem<Dim>* problem_;
  std::vector<char>* active_;
  ActiveSet set_;
  /// (unknown) not zero: held.
  std::vector<char> fixed_;
  /// (unknown) step of the held unknowns to their targets [m].
  std::vector<double> step_;
  /// (pair) normal gaps [m].
  std::vector<double> gap_;
  /// (pair) reactions [N/m in 2D].
  std::vector<double> reaction_;
  double force_tolerance_;  ///< [N/m in 2D]
};

}  // namespace dccast::mechanics
