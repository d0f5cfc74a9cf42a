#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/constrained_system.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/solve_step.hpp"
#include "core/mechanics/step_constraints.hpp"

namespace dccast::mechanics {

namespace {

// The contact set is updated only near equilibrium: far from it the reactions are meaningless.
constexpr double contact_from_residual = 1e-2;
// The primal-dual active set may cycle. After this many changes the step switches to a feasible
// descent, which cannot cycle: gaps never become negative, and every change lowers the energy. A 3D
// bottom needs more changes than a 2D one, and the descent changes one pair at a time: with 40 free
// changes a 3D step took 29 iterations, with descent after 8 changes it took 87.
template <int Dim>
constexpr int free_contact_changes = Dim == 2 ? 8 : 40;
constexpr double release_from_residual = 1e-3;
constexpr int further_iterations = 200;
// A factorisation is kept while it still reduces the residual by this ratio.
constexpr double chord_reduction = 0.25;
// In 3D an iteration with a kept factor costs a fifth of one with a new factor. Secants improve the
// kept one, until two iterations reduce the residual by less than this ratio.
constexpr double secant_reduction = 0.7;
constexpr int slow_iterations = 2;
// For solids too large for a band solver every iteration has its own tangent, solved by conjugate
// gradients only as accurately as the iteration can use: the forcing terms of Eisenstat and Walker
// (1996, choice 2).
constexpr double loosest_forcing = 1e-1;
constexpr double forcing_share = 0.9;
// The two-grid preconditioner is rebuilt for every tangent: an additional Newton iteration costs
// more than the conjugate-gradient iterations that avoid it, and with less accurate directions the
// contact set may cycle.
constexpr double grids_forcing = 1e-3;
constexpr int line_search_steps = 12;
// The line search accepts a step once the slope along the direction has decreased to this share.
constexpr double line_search_slope = 0.9;

template <int Dim>
class Newton {
public:
  Newton(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
         StepUnknowns<Dim>& unknowns)
      : problem_(problem),
        options_(options),
        work_(work),
        unknowns_(unknowns),
        equilibrium_(problem),
        system_(*problem.pattern, work),
        round_off_(round_off_force(problem)),
        constraints_(problem, unknowns.contact, round_off_),
        least_acting_(least_acting_force(problem, round_off_, options.tolerance)) {}

  StepOutcome solve() {
    count_solver_use(work_, outcome_, [this] { iterate(); });
    if (outcome_.converged) store();
    return outcome_;
  }

private:
  void iterate() {
    evaluate();
    bool full_step = false;  // held unknowns may still have to move on the first iteration
    double last = INFINITY;
    while (true) {
      const int changes = change_contact(full_step);
      const double relative = relative_residual();
      const auto step_of_fixed = constraints_.step_from(unknowns_.displacement);
      const bool lifting = std::any_of(step_of_fixed.begin(), step_of_fixed.end(),
                                       [](double d) { return d != 0.0; });

      outcome_.residual_history.push_back(relative);
      outcome_.equilibrium_residual = relative;
      if (changes == 0 && !lifting && relative <= options_.tolerance) {
        outcome_.converged = true;
        return;
      }

      if (outcome_.iterations >= most_iterations() || !std::isfinite(relative)) return;
      ++outcome_.iterations;

      const bool moved = changes > 0 || lifting || blocked_;
      const bool found = keeps_factor() ? find_direction_by_gradients(relative, last, step_of_fixed)
                                        : find_direction(relative, last, moved, step_of_fixed);
      if (!found) return;
      last = relative;
      full_step = take_step(lifting);
    }
  }

  /// The factor is kept while it reduces the residual: by chord steps in 2D, with secants in 3D.
  bool find_direction(double relative, double last, bool moved,
                      std::span<const double> step_of_fixed) {
    const bool first = outcome_.iterations == 1;
    const bool slow = first || (!moved && is_slow(relative, last));

    // The tangent is kept when the set changes near equilibrium:
    // docs/developers/factorisation.md.
    const bool kept = !slow && (!moved || system_.change(constraints_.fixed(), step_of_fixed));
    if (!kept && !factorize(step_of_fixed)) return false;
    if (!kept) slow_since_factor_ = 0;

    if (work_.has_secants()) work_.last_residual = work_.residual;
    return system_.solve(constraints_.fixed(), step_of_fixed);
  }

  /// Whether a new factorisation is better than the kept one. In 3D also updates the kept one.
  bool is_slow(double relative, double last) {
    if (!work_.has_secants()) return relative > chord_reduction * last;

    if (relative > secant_reduction * last) ++slow_since_factor_;
    if (relative > last || slow_since_factor_ == slow_iterations || work_.secants.full())
      return true;
    system_.learn(constraints_.fixed(), length_);
    return false;
  }

  /// Whether a factorisation costs as much as many solutions. A band factorisation does not, so
  /// that chord steps are faster: docs/developers/factorisation.md.
  bool keeps_factor() const {
    return work_.two_grid != nullptr || (work_.is_solid && !work_.solver.uses_band());
  }

  /// One factorisation per step; later tangents are solved with it as preconditioner. The two-grid
  /// preconditioner is rebuilt for each tangent: that costs as much as about ten iterations, and
  /// with one of an older tangent or contact set ten times as many iterations are needed.
  bool find_direction_by_gradients(double relative, double last,
                                   std::span<const double> step_of_fixed) {
    const bool first = outcome_.iterations == 1;
    if (work_.two_grid != nullptr) {
      return factorize(step_of_fixed) &&
             system_.solve(constraints_.fixed(), step_of_fixed,
                           first ? grids_forcing : forcing(relative, last, grids_forcing));
    }
    if (first) {
      return factorize(step_of_fixed) && system_.solve(constraints_.fixed(), step_of_fixed);
    }
    assemble_tangent();
    return system_.renew(constraints_.fixed(), step_of_fixed) &&
           system_.solve(constraints_.fixed(), step_of_fixed, forcing(relative, last));
  }

  /// Tolerance of conjugate gradients, not tighter than the step needs.
  double forcing(double relative, double last, double loosest = loosest_forcing) const {
    const double reduction = relative / last;
    const double needed = 0.1 * options_.tolerance / relative;
    return std::max(needed, std::min(loosest, forcing_share * reduction * reduction));
  }

  /// @return whether the full step was taken
  bool take_step(bool lifting) {
    blocked_ = pushed_back_ = false;
    if (lifting) {
      advance(1.0);
      if (descending_) constraints_.close_penetrating(unknowns_.displacement);
      return true;
    }
    if (!descending_) return search(1.0);
    const double most = constraints_.feasible_length(unknowns_.displacement, work_.direction, 1.0);
    const bool whole = search(most);
    if (most < 1.0 && whole) {
      blocked_ = constraints_.close_blocking(unknowns_.displacement, work_.direction) > 0;
      pushed_back_ = most == 0.0;
      one_by_one_ = one_by_one_ || pushed_back_;
    }
    return whole && most == 1.0;
  }

  /// A limit that the case sets holds; the default one leaves the descent, which changes one pair
  /// at a time, as many iterations as it needs.
  int most_iterations() const {
    const bool further = descending_ && !options_.maximum_iterations;
    return iteration_limit(options_) + (further ? further_iterations : 0);
  }

  double relative_residual() const { return constraints_.norm_of_free(work_.residual) / acting_; }

  bool factorize(std::span<const double> step_of_fixed) {
    assemble_tangent();
    return system_.factorize(constraints_.fixed(), step_of_fixed);
  }

  void assemble_tangent() {
    const Stopwatch watch(work_.cost.stiffness);
    equilibrium_.tangent(work_.stiffness);
  }

  void evaluate() {
    const Stopwatch watch(work_.cost.forces);
    const double acting =
        equilibrium_.residual(unknowns_.displacement, work_.residual, return_map_law(problem_));
    acting_ = std::max(acting, least_acting_);
  }

  void advance(double length) {
    for (std::size_t i = 0; i < unknowns_.displacement.size(); ++i) {
      unknowns_.displacement[i] += length * work_.direction[i];
    }
    evaluate();
  }

  /// Derivative of the step's energy along the direction: the energy is convex, so it grows from
  /// its negative start and crosses zero at the minimum.
  double slope() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < work_.residual.size(); ++i) {
      if (constraints_.fixed()[i] == 0) sum += work_.residual[i] * work_.direction[i];
    }
    return sum;
  }

  /// Energy line search by the secant method on the slope, up to a length. @return whether the full
  /// length was taken
  bool search(double most) {
    const double start = slope();
    advance(most);
    length_ = most;
    double low = 0.0, low_slope = start, high = 0.0, high_slope = 0.0;
    for (int i = 0; i < line_search_steps; ++i) {
      const double now = slope();
      if (std::isfinite(now) && now <= -line_search_slope * start) return length_ == most;
      high = length_, high_slope = now;
      const double secant = std::isfinite(now)
                                ? low - low_slope * (high - low) / (high_slope - low_slope)
                                : 0.1 * high;
      const double next = std::clamp(secant, low + 0.05 * (high - low), low + 0.7 * (high - low));
      advance(next - length_);
      length_ = next;
    }
    return false;
  }

  /// Updates the contact set. @return number of pairs that changed
  int change_contact(bool full_step) {
    const Stopwatch watch(work_.cost.contact);
    const double relative = relative_residual();
    // A state in equilibrium is always checked, however it was reached: it may be the solution.
    const bool balanced = relative <= options_.tolerance;

    int changes = 0;
    if (descending_) {
      // If a released pair is closed again by the next iteration, its tension came from unbalanced
      // forces: equilibrium is restored first, or release and closing would alternate forever.
      if (relative <= release_from_residual && !pushed_back_) {
        changes = constraints_.release(unknowns_.displacement, work_.residual, one_by_one_);
      }
    } else if (balanced || (full_step && relative <= contact_from_residual)) {
      changes = constraints_.update(unknowns_.displacement, work_.residual, false);
    }

    outcome_.contact_changes += changes > 0 ? 1 : 0;
    if (!descending_ && outcome_.contact_changes > free_contact_changes<Dim>) {
      descending_ = true;
      changes += constraints_.close_penetrating(unknowns_.displacement);
    }
    return changes;
  }

  void store() {
    constraints_.store();
    unknowns_.deviator = equilibrium_.deviators();
    outcome_.forces_at_end = {acting_, round_off_};
  }

  const StepProblem<Dim>& problem_;
  const Options& options_;
  Workspace& work_;
  StepUnknowns<Dim>& unknowns_;
  Equilibrium<Dim> equilibrium_;
  ConstrainedSystem system_;
  double round_off_;  ///< [N/m in 2D]
  StepConstraints<Dim> constraints_;
  StepOutcome outcome_;
  double least_acting_;
  double acting_ = 0.0;
  double length_ = 0.0;        ///< share of the last direction that was taken [1]
  int slow_since_factor_ = 0;  ///< iterations that hardly reduced the residual
  bool descending_ = false;    ///< the contact set moves by feasible descent
  bool blocked_ = false;       ///< the last step ended at a pair that closed
  bool pushed_back_ = false;   ///< that step had zero length
  bool one_by_one_ = false;    ///< releasing several pairs at once did not succeed
};

}  // namespace

template <int Dim>
StepOutcome solve_newton(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
                         StepUnknowns<Dim>& unknowns) {
  return Newton<Dim>(problem, options, work, unknowns).solve();
}

template StepOutcome solve_newton(const StepProblem<2>&, const Options&, Workspace&,
                                  StepUnknowns<2>&);
template StepOutcome solve_newton(const StepProblem<3>&, const Options&, Workspace&,
                                  StepUnknowns<3>&);

template <int Dim>
StepOutcome solve_step(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
                       StepUnknowns<Dim>& unknowns) {
  switch (options.algorithm) {
    case Algorithm::newton:
      return solve_newton(problem, options, work, unknowns);
    case Algorithm::vnbm:
      return solve_vnbm(problem, options, work, unknowns);
    case Algorithm::sbm:
      return solve_sbm(problem, options, work, unknowns);
    case Algorithm::nbm:
      return solve_nbm(problem, options, work, unknowns);
  }
  throw std::logic_error("solve_step: an algorithm without a solver");
}

template StepOutcome solve_step(const StepProblem<2>&, const Options&, Workspace&,
                                StepUnknowns<2>&);
template StepOutcome solve_step(const StepProblem<3>&, const Options&, Workspace&,
                                StepUnknowns<3>&);

}  // namespace dccast::mechanics
