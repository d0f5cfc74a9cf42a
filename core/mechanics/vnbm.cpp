#include <cmath>

#include "core/mechanics/multiplier_method.hpp"
#include "core/mechanics/step_constraints.hpp"

namespace dccast::mechanics {

namespace {

constexpr double contact_from_residual = 1e-3;

/// gamma_p of eq. (77) at the stress of the step's start, sqrt(q-1) kappa |s|^(q-2). The formula is
/// zero where there is no stress yet, and a multiplier with gamma_p = 0 does not contract; its
/// floor is the compliance of one elastic step, 1 / (2 mu dt).
template <int Dim>
std::vector<double> variable_gamma(const StepProblem<Dim>& problem,
                                   const StepUnknowns<Dim>& unknowns) {
  std::vector<double> gamma(problem.inelastic.size(), 0.0);
  for (std::size_t i = 0; i < gamma.size(); ++i) {
    const std::size_t e = i / problem.forms->points();
    if (problem.kappa[e] <= 0.0) continue;
    const double norm = unknowns.deviator.empty() ? 0.0 : unknowns.deviator[i].norm();
    gamma[i] = std::max(std::sqrt(problem.exponent - 1.0) * problem.kappa[e] *
                            material::creep_power(norm, problem.exponent),
                        1.0 / (2.0 * problem.shear[e] * problem.dt));
  }
  return gamma;
}

/// Paper section 4.4.1, steps VNBM2(a) to (e).
template <int Dim>
class Vnbm : MultiplierMethod<Dim> {
  using Base = MultiplierMethod<Dim>;
  using Tensor = typename Base::Tensor;

public:
  Vnbm(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
       StepUnknowns<Dim>& unknowns)
      : Base(problem, options, work, unknowns, variable_gamma(problem, unknowns)),
        constraints_(problem, unknowns.contact, this->round_off_) {}

  StepOutcome solve() {
    return this->solve_with(constraints_, [this] { iterate(); });
  }

private:
  void iterate() {
    StepOutcome& outcome = this->outcome_;
    bool refactor = true;
    while (outcome.iterations < iteration_limit(this->options_)) {
      ++outcome.iterations;
      if (!solve_displacement(refactor)) return;

      this->settled_ = true;
      this->evaluate(updating_law());
      refactor = this->close_contact(constraints_, this->relative_residual(constraints_.fixed()),
                                     contact_from_residual);

      const double relative = this->relative_residual(constraints_.fixed());  // of the new set
      outcome.residual_history.push_back(relative);
      outcome.equilibrium_residual = relative;
      if (!std::isfinite(relative)) return;

      if (this->options_.parameters.increment_test) {
        if (refactor || !this->settled_) continue;
        this->accept_increment(constraints_.fixed());
        return;
      }

      if (refactor || relative > this->options_.tolerance) continue;
      outcome.equilibrium_residual = this->true_residual(constraints_.fixed());
      if (outcome.equilibrium_residual <= this->options_.tolerance) {
        outcome.converged = true;
        return;
      }
      this->evaluate(this->multiplier_law());
    }
  }

  /// VNBM2(b)(i).
  bool solve_displacement(bool refactor) {
    const auto step = constraints_.step_from(this->unknowns_.displacement);
    if (refactor && !this->hold(constraints_.fixed(), step)) return false;
    if (!this->system_.solve(constraints_.fixed(), step)) return false;
    this->advance();
    return true;
  }

  /// VNBM2(c) and (d) in one pass.
  auto updating_law() {
    return [this](std::size_t e, std::size_t point, const Tensor& trial) {
      return this->update_multiplier(e, point, trial, 0.5 / this->gamma_p_[point]);
    };
  }

  StepConstraints<Dim> constraints_;
};

}  // namespace

template <int Dim>
StepOutcome solve_vnbm(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
                       StepUnknowns<Dim>& unknowns) {
  return Vnbm<Dim>(problem, options, work, unknowns).solve();
}

template StepOutcome solve_vnbm(const StepProblem<2>&, const Options&, Workspace&,
                                StepUnknowns<2>&);
template StepOutcome solve_vnbm(const StepProblem<3>&, const Options&, Workspace&,
                                StepUnknowns<3>&);

}  // namespace dccast::mechanics
