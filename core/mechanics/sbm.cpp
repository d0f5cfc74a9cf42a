#include <cmath>

#include "core/mechanics/multiplier_method.hpp"
#include "core/mechanics/step_constraints.hpp"

namespace dccast::mechanics {

namespace {

// Gap or penetration that may be left at a contact unknown [m]. The residual alone does not see it:
// with the small gamma_c of a casting a penetration of 0.01 mm is a force that is negligible beside
// the thermal stresses.
constexpr double contact_tolerance = 1e-6;

/// Constant gamma_p; elements without creep have none.
template <int Dim>
std::vector<double> constant_gamma(const StepProblem<Dim>& problem, double gamma_p) {
  std::vector<double> gamma(problem.inelastic.size(), 0.0);
  for (std::size_t i = 0; i < gamma.size(); ++i) {
    if (problem.kappa[i / problem.forms->points()] > 0.0) gamma[i] = gamma_p;
  }
  return gamma;
}

/// Paper section 4.2.3, steps SBM2(a) to (e): both multipliers by the Yosida approximation with
/// constant parameters, one matrix for the whole step.
template <int Dim>
class Sbm : MultiplierMethod<Dim> {
  using Base = MultiplierMethod<Dim>;
  using Tensor = typename Base::Tensor;

public:
  Sbm(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
      StepUnknowns<Dim>& unknowns)
      : Base(problem, options, work, unknowns,
             constant_gamma(problem, options.parameters.gamma_p)) {
    const AlgorithmParameters& p = options.parameters;
    lambda_p_ = p.lambda_p.value_or(0.5 / p.gamma_p);
    lambda_c_ = p.lambda_c.value_or(0.5 / p.gamma_c);
    start_contact_multiplier();
  }

  StepOutcome solve() {
    StepOutcome& outcome = this->outcome_;
    count_solver_use(this->work_, outcome, [this] { iterate(); });
    if (outcome.converged) store();
    return outcome;
  }

private:
  /// SBM1 and SBM2(a): the multiplier of the last step, in the first step the weight of the metal.
  void start_contact_multiplier() {
    auto& p = this->unknowns_.contact_multiplier;
    const auto& area = this->problem_.contact_area;
    if (p.size() == area.size()) return;
    const std::size_t carrying = this->problem_.carrying();
    double sum = 0.0;
    for (std::size_t i = 0; i < carrying; ++i) sum += area[i];
    p.assign(carrying, sum > 0.0 ? this->problem_.weight / sum : 0.0);
    p.resize(area.size(), 0.0);
  }

  void iterate() {
    StepOutcome& outcome = this->outcome_;
    const int most = iteration_limit(this->options_);
    if (!factorize()) return;

    add_contact_forces();
    while (outcome.iterations < most) {
      ++outcome.iterations;
      if (!this->system_.solve(this->problem_.fixed, step_)) return;
      this->advance();
      step_.assign(step_.size(), 0.0);

      // Both multipliers take their value at the new displacement.
      this->settled_ = true;
      this->evaluate(updating_law());
      update_contact_multiplier();
      add_contact_forces();

      const double relative = this->relative_residual(this->problem_.fixed);
      outcome.residual_history.push_back(relative);
      outcome.equilibrium_residual = relative;
      if (!std::isfinite(relative)) return;

      if (this->options_.parameters.increment_test) {
        if (!this->settled_) continue;
        this->accept_increment(this->problem_.fixed);
        outcome.equilibrium_residual = relative;
        return;
      }
      // The multiplier's stress is in equilibrium; the stress of the law has to be, too.
      if (relative > this->options_.tolerance) continue;
      outcome.equilibrium_residual = own_residual();
      if (outcome.equilibrium_residual <= this->options_.tolerance &&
          contact_violation_ <= contact_tolerance) {
        outcome.converged = true;
        return;
      }

      // Back to the multiplier's stress, which own_residual() has replaced.
      this->evaluate(this->multiplier_law());
      add_contact_forces();
    }
  }

  bool factorize() {
    const auto& problem = this->problem_;
    step_.assign(problem.unknowns(), 0.0);
    for (std::size_t i = 0; i < step_.size(); ++i) {
      if (problem.fixed[i] != 0) step_[i] = problem.target[i] - this->unknowns_.displacement[i];
    }
    this->evaluate(this->multiplier_law());
    this->equilibrium_.tangent(this->work_.stiffness);
    for (std::size_t i = 0; i < problem.contact.size(); ++i) {
      const int diagonal = problem.pattern->diagonal(problem.contact[i]);
      this->work_.stiffness[std::size_t(diagonal)] +=
          this->options_.parameters.gamma_c * problem.contact_area[i];
    }
    return this->system_.factorize(problem.fixed, step_);
  }

  /// The terms gamma_c u_n v_n and p v_n of (51). u_n counts from the block or wall into it: minus
  /// the gap.
  void add_contact_forces() {
    const auto& problem = this->problem_;
    for (std::size_t i = 0; i < problem.contact.size(); ++i) {
      const double u_n = -problem.normal_gap(i, this->unknowns_.displacement);
      const double pressure =
          this->unknowns_.contact_multiplier[i] + this->options_.parameters.gamma_c * u_n;
      this->work_.residual[std::size_t(problem.contact[i])] -=
          problem.sense(i) * (problem.contact_area[i] * pressure);
    }
  }

  /// SBM2(d), relaxed as Remark 4 says.
  void update_contact_multiplier() {
    const double theta = this->options_.parameters.relaxation;
    for (std::size_t i = 0; i < this->problem_.contact.size(); ++i) {
      double& p = this->unknowns_.contact_multiplier[i];
      const double before = p;
      p = theta * mapped_contact_multiplier(i) + (1.0 - theta) * p;
      if (this->options_.parameters.increment_test) {
        this->test_increment(before, p, mapped_contact_multiplier(i));
      }
    }
  }

  /// G_lambda(u_n + lambda_c p) at one contact unknown [Pa].
  double mapped_contact_multiplier(std::size_t i) const {
    const double s = -this->problem_.normal_gap(i, this->unknowns_.displacement) +
                     lambda_c_ * this->unknowns_.contact_multiplier[i];
    const double projected =
        std::min(s / (1.0 - lambda_c_ * this->options_.parameters.gamma_c), 0.0);
    return (s - projected) / lambda_c_;
  }

  /// SBM2(c) and (e) in one pass, as in vnbm but with constant parameters.
  auto updating_law() {
    return [this](std::size_t e, std::size_t point, const Tensor& trial) {
      return this->update_multiplier(e, point, trial, lambda_p_);
    };
  }

  /// Residual of the step's own law and of Signorini's conditions: at a contact unknown with
  /// internal minus external force r, zero of r - max(0, r - c gap).
  double own_residual() {
    this->true_residual(this->problem_.fixed);
    const double scale = 2.0 * this->options_.parameters.gamma_c;
    contact_violation_ = 0.0;
    for (std::size_t i = 0; i < this->problem_.contact.size(); ++i) {
      const std::size_t unknown = std::size_t(this->problem_.contact[i]);
      double& r = this->work_.residual[unknown];
      const double sense = this->problem_.sense(i);
      const double pushed =
          sense * r - scale * this->problem_.contact_area[i] *
                          this->problem_.normal_gap(i, this->unknowns_.displacement);
      r -= sense * std::max(0.0, pushed);
      contact_violation_ =
          std::max(contact_violation_, std::abs(r) / (scale * this->problem_.contact_area[i]));
    }
    return this->relative_residual(this->problem_.fixed);
  }

  /// A pair is closed if its pressure p - gamma_c gap dominates its gap. The pressure alone is not
  /// sufficient: for an open pair it is zero up to round-off of either sign.
  void store() {
    this->store_deviator();
    const double gamma_c = this->options_.parameters.gamma_c;
    for (std::size_t i = 0; i < this->problem_.contact.size(); ++i) {
      const double gap = this->problem_.normal_gap(i, this->unknowns_.displacement);
      this->unknowns_.contact[i] =
          this->unknowns_.contact_multiplier[i] - gamma_c * gap > gamma_c * gap;
    }
  }

  std::vector<double> step_;
  double lambda_p_ = 0.0;
  double lambda_c_ = 0.0;
  double contact_violation_ = 0.0;  ///< [m]
};

}  // namespace

template <int Dim>
StepOutcome solve_sbm(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
                      StepUnknowns<Dim>& unknowns) {
  return Sbm<Dim>(problem, options, work, unknowns).solve();
}

template StepOutcome solve_sbm(const StepProblem<2>&, const Options&, Workspace&, StepUnknowns<2>&);
template StepOutcome solve_sbm(const StepProblem<3>&, const Options&, Workspace&, StepUnknowns<3>&);

}  // namespace dccast::mechanics
