#include <cmath>

#include "core/mechanics/multiplier_method.hpp"
#include "core/mechanics/step_constraints.hpp"

namespace dccast::mechanics {

namespace {

constexpr double contact_from_residual = 1e-2;
// Armijo's rule (Bertsekas): required share of the predicted decrease [1], and smallest step length
// [1] before an iteration is abandoned.
constexpr double armijo_share = 1e-2;
constexpr double armijo_smallest = 1.0 / 1024.0;

/// The recurrence (74): the fixed point of the linearised Yosida equation (72) with gamma_p = 0.
template <class Tensor>
Tensor recurrence(const Tensor& deviator, const Tensor& multiplier, double kappa, double exponent,
                  double lambda_p) {
  Tensor zeta = deviator;
  zeta.add(lambda_p, multiplier);
  const double norm = zeta.norm();
  if (norm == 0.0) return Tensor{};
  const double eta =
      material::yosida_root(lambda_p * kappa * material::creep_power(norm, exponent), exponent);
  double projection = 0.0;  // q : zeta
  for (std::size_t i = 0; i < Tensor::components; ++i) {
    projection += (i < 3 ? 1.0 : 2.0) * multiplier[i] * zeta[i];
  }
  Tensor q = deviator;
  q.add((eta - 1.0) * (exponent - 2.0) / eta, zeta);
  for (double& component : q.value) component *= (eta - 1.0) / lambda_p;
  q.add(-(eta - 1.0) * (exponent - 2.0) * projection / (norm * norm), zeta);
  return q;
}

/// Paper section 4.3.3, steps NBM2(a) to (d), with Armijo's rule of section 4.3.4 unless plain. The
/// reduction of the time step, the other improvement, is the step control's.
template <int Dim>
class Nbm : MultiplierMethod<Dim> {
  using Base = MultiplierMethod<Dim>;
  using Tensor = typename Base::Tensor;

public:
  Nbm(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
      StepUnknowns<Dim>& unknowns)
      : Base(problem, options, work, unknowns, std::vector<double>(problem.inelastic.size(), 0.0)),
        constraints_(problem, unknowns.contact, this->round_off_) {}

  StepOutcome solve() {
    return this->solve_with(constraints_, [this] { iterate(); });
  }

private:
  void iterate() {
    StepOutcome& outcome = this->outcome_;
    while (outcome.iterations < iteration_limit(this->options_)) {
      if (!solve_displacement()) return;

      outcome.equilibrium_residual = this->true_residual(constraints_.fixed());
      const double relative = outcome.equilibrium_residual;
      outcome.residual_history.push_back(relative);
      if (!std::isfinite(relative)) return;

      refactor_ = this->close_contact(constraints_, relative, contact_from_residual);
      if (!refactor_ && relative <= this->options_.tolerance) {
        outcome.converged = true;
        return;
      }
      if (refactor_) continue;

      if (!move_multiplier()) return;
      if (this->options_.parameters.increment_test && increments_settled()) {
        this->accept_increment(constraints_.fixed());
        return;
      }
    }
  }

  /// The paper's stopping test on the last change of the multipliers.
  bool increments_settled() {
    const std::vector<Tensor> mapped = next_multipliers();
    this->settled_ = true;
    for (std::size_t i = 0; i < mapped.size(); ++i) {
      this->test_increment(before_[i], this->multiplier_[i], mapped[i]);
    }
    return this->settled_;
  }

  /// NBM2(b)(i) with the present multiplier; the residual afterwards is round-off.
  bool solve_displacement() {
    ++this->outcome_.iterations;
    const auto step = constraints_.step_from(this->unknowns_.displacement);
    if (refactor_ && !this->hold(constraints_.fixed(), step)) return false;
    refactor_ = false;
    this->evaluate(this->multiplier_law());
    if (!this->system_.solve(constraints_.fixed(), step)) return false;
    this->advance();
    this->evaluate(this->multiplier_law());
    return true;
  }

  /// NBM2(d) with relaxation; unless plain, the step is shortened until the distance of q to H(s)
  /// decreases.
  bool move_multiplier() {
    this->evaluate(this->multiplier_law());
    before_ = this->multiplier_;
    const std::vector<Tensor>& start = before_;
    const std::vector<Tensor> target = next_multipliers();
    const double distance = distance_to_law();
    double length = this->options_.parameters.relaxation;

    while (true) {
      for (std::size_t i = 0; i < start.size(); ++i) {
        for (std::size_t c = 0; c < Tensor::components; ++c) {
          this->multiplier_[i][c] = start[i][c] + length * (target[i][c] - start[i][c]);
        }
      }

      if (this->options_.parameters.plain) return true;
      if (this->outcome_.iterations >= iteration_limit(this->options_)) return false;
      if (!solve_displacement()) return false;
      if (distance_to_law() <= (1.0 - armijo_share * length) * distance) return true;
      length *= 0.5;
      if (length < armijo_smallest) return false;
    }
  }

  std::vector<Tensor> next_multipliers() const {
    std::vector<Tensor> next(this->multiplier_.size());
    for (std::size_t i = 0; i < next.size(); ++i) {
      const std::size_t e = i / this->problem_.forms->points();
      if (this->problem_.kappa[e] <= 0.0) continue;
      // lambda_p carries a unit; taken as the creep of one elastic step it makes the recurrence
      // dimensionless, which is what the paper's scaling of the stresses does. Its value does not
      // change the iterates' fixed point.
      const double lambda = this->options_.parameters.lambda_p.value_or(
          2.0 * this->problem_.shear[e] * this->problem_.dt);
      next[i] = recurrence(this->equilibrium_.deviator(i), this->multiplier_[i],
                           this->problem_.kappa[e], this->problem_.exponent, lambda);
    }
    return next;
  }

  /// Root of the sum of |2 mu dt (q - H(s))|^2 over the points [Pa].
  double distance_to_law() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < this->multiplier_.size(); ++i) {
      const std::size_t e = i / this->problem_.forms->points();
      if (this->problem_.kappa[e] <= 0.0) continue;
      Tensor d = viscoplastic_strain_rate(this->problem_, e, this->equilibrium_.deviator(i));
      d.add(-1.0, this->multiplier_[i]);
      const double stress = 2.0 * this->problem_.shear[e] * this->problem_.dt * d.norm();
      sum += stress * stress;
    }
    return std::sqrt(sum);
  }

  StepConstraints<Dim> constraints_;
  std::vector<Tensor> before_;  ///< multipliers before their last change [1/s]
  bool refactor_ = true;
};

}  // namespace

template <int Dim>
StepOutcome solve_nbm(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
                      StepUnknowns<Dim>& unknowns) {
  return Nbm<Dim>(problem, options, work, unknowns).solve();
}

template StepOutcome solve_nbm(const StepProblem<2>&, const Options&, Workspace&, StepUnknowns<2>&);
template StepOutcome solve_nbm(const StepProblem<3>&, const Options&, Workspace&, StepUnknowns<3>&);

}  // namespace dccast::mechanics
