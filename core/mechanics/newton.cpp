#include <algorithm>
#include <cmath>

#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/constrained_system.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/solve_step.hpp"
#include "core/mechanics/step_constraints.hpp"

namespace dccast::mechanics {

namespace {

// The contact set moves only when the forces are roughly in balance: reactions of an unbalanced
// state say nothing.
constexpr double contact_from_residual = 1e-2;
// After so many changes pairs go one by one, and only close to balance.
constexpr int free_contact_changes = 8;
constexpr double careful_contact_from_residual = 1e-3;
// A factor is kept while it still reduces the residual by this much.
constexpr double chord_reduction = 0.25;
constexpr int line_search_steps = 12;
// A step is good enough once the slope along it has come down to this share.
constexpr double line_search_slope = 0.9;

template <class Element>
class Newton {
public:
  Newton(const StepProblem<Element>& problem, const Options& options, Workspace& work,
         StepUnknowns<Element>& unknowns)
      : problem_(problem), options_(options), work_(work), unknowns_(unknowns),
        equilibrium_(problem), system_(*problem.pattern, work),
        constraints_(problem, unknowns.contact) {}

  StepOutcome solve() {
    const long factorizations = work_.solver.factorizations(), solves = work_.solver.solves();
    iterate();
    outcome_.factorizations = static_cast<int>(work_.solver.factorizations() - factorizations);
    outcome_.solves = static_cast<int>(work_.solver.solves() - solves);
    if (outcome_.converged) store();
    return outcome_;
  }

private:
  void iterate() {
    evaluate();
    bool full_step = false;  // held unknowns may still have to move on the first iteration
    double last = INFINITY;
    while (true) {
      const int changes = update_contact(full_step);
      const double relative = constraints_.norm_of_free(work_.residual) / acting_;
      const auto step_of_fixed = constraints_.step_from(unknowns_.displacement);
      const bool lifting = std::any_of(step_of_fixed.begin(), step_of_fixed.end(),
                                       [](double d) { return d != 0.0; });
      outcome_.residual_history.push_back(relative);
      outcome_.equilibrium_residual = relative;
      if (changes == 0 && !lifting && relative <= options_.tolerance) {
        outcome_.converged = true;
        return;
      }
      if (outcome_.iterations == iteration_limit(options_) || !std::isfinite(relative)) return;
      ++outcome_.iterations;
      const bool refactor = outcome_.iterations == 1 || changes > 0 || lifting ||
                            relative > chord_reduction * last;
      last = relative;
      if (refactor && !factorize(step_of_fixed)) return;
      system_.solve(constraints_.fixed(), step_of_fixed);
      full_step = lifting ? (advance(1.0), true) : search();
    }
  }

  bool factorize(std::span<const double> step_of_fixed) {
    equilibrium_.tangent(work_.stiffness);
    return system_.factorize(constraints_.fixed(), step_of_fixed);
  }

  void evaluate() {
    acting_ = equilibrium_.residual(unknowns_.displacement, work_.residual,
                                    return_map_law(problem_));
    acting_ = std::max(acting_, std::max(problem_.weight, 1e-300));
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

  /// Energy line search by secants on the slope. @return whether the full step was taken
  bool search() {
    const double start = slope();
    advance(1.0);
    double at = 1.0, low = 0.0, low_slope = start, high = 0.0, high_slope = 0.0;
    for (int i = 0; i < line_search_steps; ++i) {
      const double now = slope();
      if (std::isfinite(now) && now <= -line_search_slope * start) return at == 1.0;
      high = at, high_slope = now;
      const double secant = std::isfinite(now)
                                ? low - low_slope * (high - low) / (high_slope - low_slope)
                                : 0.1 * high;
      const double next = std::clamp(secant, low + 0.05 * (high - low), low + 0.7 * (high - low));
      advance(next - at);
      at = next;
    }
    return false;
  }

  int update_contact(bool full_step) {
    const double relative = constraints_.norm_of_free(work_.residual) / acting_;
    const bool careful = outcome_.contact_changes > free_contact_changes;
    const double from = careful ? careful_contact_from_residual : contact_from_residual;
    // A state in balance is always asked, whatever led to it: it may be the answer.
    const bool balanced = relative <= options_.tolerance;
    if (!balanced && (!full_step || relative > from)) return 0;
    const int changes =
        constraints_.update(unknowns_.displacement, work_.residual, careful);
    outcome_.contact_changes += changes > 0 ? 1 : 0;
    return changes;
  }

  void store() {
    constraints_.store();
    unknowns_.deviator.resize(equilibrium_.response().size());
    for (std::size_t i = 0; i < unknowns_.deviator.size(); ++i) {
      unknowns_.deviator[i] = equilibrium_.response()[i].deviator;
    }
  }

  const StepProblem<Element>& problem_;
  const Options& options_;
  Workspace& work_;
  StepUnknowns<Element>& unknowns_;
  Equilibrium<Element> equilibrium_;
  ConstrainedSystem system_;
  StepConstraints<Element> constraints_;
  StepOutcome outcome_;
  double acting_ = 0.0;
};

}  // namespace

template <class Element>
StepOutcome solve_newton(const StepProblem<Element>& problem, const Options& options,
                         Workspace& work, StepUnknowns<Element>& unknowns) {
  return Newton<Element>(problem, options, work, unknowns).solve();
}

template StepOutcome solve_newton(const StepProblem<fem::P1Triangle>&, const Options&, Workspace&,
                                  StepUnknowns<fem::P1Triangle>&);
template StepOutcome solve_newton(const StepProblem<fem::Q1Quadrilateral>&, const Options&,
                                  Workspace&, StepUnknowns<fem::Q1Quadrilateral>&);

}  // namespace dccast::mechanics
