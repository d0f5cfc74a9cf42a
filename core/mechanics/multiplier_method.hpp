#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/material/norton_hoff.hpp"
#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/constrained_system.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/solve_step.hpp"
#include "core/mechanics/step_constraints.hpp"

namespace dccast::mechanics {

/// The Yosida update (56) of one multiplier: q <- (zeta / lambda_p) (1 - 1 / (eta (1 - lambda_p
/// gamma_p))) with zeta = s + lambda_p q.
/// @param deviator    s [Pa]
/// @param multiplier  q [1/s]
/// @param kappa       [Pa^-(exponent-1)/s]
/// @param exponent    [1]
/// @param gamma_p     [1/(Pa s)]
/// @param lambda_p    [Pa s]
template <class Tensor>
Tensor yosida_update(const Tensor& deviator, const Tensor& multiplier, double kappa,
                     double exponent, double gamma_p, double lambda_p) {
  Tensor zeta = deviator;
  zeta.add(lambda_p, multiplier);
  const double complement = 1.0 - lambda_p * gamma_p;
  const double load = lambda_p * kappa / std::pow(complement, exponent - 1.0) *
                      material::creep_power(zeta.norm(), exponent);
  const double eta = material::yosida_root(load, exponent);
  const double factor = (1.0 - 1.0 / (eta * complement)) / lambda_p;
  for (double& z : zeta.value) z *= factor;
  return zeta;
}

/// Common part of the paper's three algorithms: they compute the displacement and the viscoplastic
/// multiplier q alternately; the matrix of the linear problem for the displacement does not depend
/// on q.
///
/// With q = H(s) - gamma_p s (eq. 53) the law reads s = 2 mu~ (e - dt q) with mu~ = mu / (1 + 2 mu
/// gamma_p dt) and the bulk modulus unchanged, which is Lemma 2 in the simpler form of the same
/// equations.
template <int Dim>
class MultiplierMethod {
public:
  using Problem = StepProblem<Dim>;
  using Tensor = typename Problem::Tensor;

  /// @param gamma_p  by point [1/(Pa s)]; ignored where there is no creep
  MultiplierMethod(const Problem& problem, const Options& options, Workspace& work,
                   StepUnknowns<Dim>& unknowns, std::vector<double> gamma_p)
      : problem_(problem),
        options_(options),
        work_(work),
        unknowns_(unknowns),
        equilibrium_(problem),
        system_(*problem.pattern, work),
        gamma_p_(std::move(gamma_p)),
        multiplier_(gamma_p_.size()),
        round_off_(round_off_force(problem)),
        least_acting_(least_acting_force(problem, round_off_, options.tolerance)) {
    unknowns_.deviator.resize(gamma_p_.size());
    for (std::size_t i = 0; i < multiplier_.size(); ++i) {
      // H(s) - gamma_p s at the start of the step, with the parameters of this step: the multiplier
      // depends on gamma_p and has to be recomputed when gamma_p changes.
      multiplier_[i] =
          viscoplastic_strain_rate(problem_, i / problem_.forms->points(), unknowns_.deviator[i]);
      multiplier_[i].add(-gamma_p_[i], unknowns_.deviator[i]);
    }
  }

protected:
  static constexpr double increment_delta = 1e-3;  // [1] as in the paper's test T2

  /// mu~ [Pa]
  double softened_shear(std::size_t e, std::size_t point) const {
    const double mu = problem_.shear[e];
    return mu / (1.0 + 2.0 * mu * gamma_p_[point] * problem_.dt);
  }

  /// The law s(trial deviator) with the present multiplier.
  auto multiplier_law() {
    return [this](std::size_t e, std::size_t point, const Tensor& trial) {
      return response(e, point, trial);
    };
  }

  /// The law with the present multiplier at a point: s = 2 mu~ (e - dt q).
  /// @param trial  e, strain deviator less the inelastic strain [1]
  PointResponse<Dim> response(std::size_t e, std::size_t point, const Tensor& trial) const {
    PointResponse<Dim> r;
    r.shear = softened_shear(e, point);
    r.softening = 0.0;
    r.deviator = trial;
    if (problem_.kappa[e] > 0.0) r.deviator.add(-problem_.dt, multiplier_[point]);
    for (double& s : r.deviator.value) s *= 2.0 * r.shear;
    return r;
  }

  /// SBM2(c) and (e) of one point: stress from the old multiplier, new multiplier from that stress,
  /// relaxed as in Remark 4, and the response with the new multiplier for the next residual.
  /// @param lambda_p  [Pa s]
  PointResponse<Dim> update_multiplier(std::size_t e, std::size_t point, const Tensor& trial,
                                       double lambda_p) {
    const auto old = response(e, point, trial);
    if (problem_.kappa[e] <= 0.0) return old;
    const double theta = options_.parameters.relaxation;
    const auto yosida = [&](const Tensor& q) {
      return yosida_update(old.deviator, q, problem_.kappa[e], problem_.exponent, gamma_p_[point],
                           lambda_p);
    };
    Tensor& q = multiplier_[point];
    const Tensor before = q, next = yosida(q);
    for (std::size_t i = 0; i < Tensor::components; ++i) {
      q[i] = theta * next[i] + (1.0 - theta) * q[i];
    }
    if (options_.parameters.increment_test) test_increment(before, q, yosida(q));
    return response(e, point, trial);
  }

  /// The paper's stopping test (T2, section 4.3.1) on one component of a multiplier [1/s]: its last
  /// change and its distance to the image of the fixed-point map must both be below delta
  /// max(delta, |value|). The test ignores equilibrium and stops too early; it exists for tables 7
  /// and 8 only.
  /// @param before  [1/s] @param now  [1/s] @param mapped  [1/s]
  void test_increment(double before, double now, double mapped) {
    const auto small = [](double difference, double value) {
      return std::abs(difference) < increment_delta * std::max(increment_delta, std::abs(value));
    };
    settled_ = settled_ && small(now - before, now) && small(now - mapped, mapped);
  }
  /// The test for every component of a tensor.
  void test_increment(const Tensor& before, const Tensor& now, const Tensor& mapped) {
    for (std::size_t i = 0; i < Tensor::components; ++i) {
      test_increment(before[i], now[i], mapped[i]);
    }
  }

  /// Ends a step that passed the increment test: reports its true residual and keeps the stresses
  /// given by its multipliers.
  void accept_increment(std::span<const char> fixed) {
    outcome_.equilibrium_residual = true_residual(fixed);
    evaluate(multiplier_law());
    outcome_.converged = true;
  }

  /// Runs the iterations of a step with an active set for contact. If it converges, the set and the
  /// stresses are stored.
  template <class Iterate>
  StepOutcome solve_with(StepConstraints<Dim>& constraints, Iterate&& iterate) {
    count_solver_use(work_, outcome_, iterate);
    if (outcome_.converged) {
      constraints.store();
      store_deviator();
    }
    return outcome_;
  }

  /// Evaluates the residual with a law. The law may update the multipliers at the same time.
  template <class Law>
  void evaluate(Law&& law) {
    acting_ =
        std::max(equilibrium_.residual(unknowns_.displacement, work_.residual, law), least_acting_);
  }

  /// Relative residual [1] with the constitutive law itself, which decides about convergence.
  /// Leaves the stresses of this law in `equilibrium_` and their difference to those of the
  /// multiplier in the outcome.
  double true_residual(std::span<const char> fixed) {
    const std::vector<Tensor> own = equilibrium_.deviators();
    evaluate(return_map_law(problem_));
    double difference = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < own.size(); ++i) {
      Tensor d = equilibrium_.deviator(i);
      scale += d.norm() * d.norm();
      d.add(-1.0, own[i]);
      difference += d.norm() * d.norm();
    }
    outcome_.constitutive_residual = scale > 0.0 ? std::sqrt(difference / scale) : 0.0;
    return relative_residual(fixed);
  }

  /// Norm of the residual on the free unknowns, relative to the acting forces [1].
  double relative_residual(std::span<const char> fixed) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < work_.residual.size(); ++i) {
      if (fixed[i] == 0) sum += work_.residual[i] * work_.residual[i];
    }
    return std::sqrt(sum) / acting_;
  }

  /// Updates the contact set by Newton's method, NBM2(b)(ii). It may change at every iteration, as
  /// in the paper's loop, but not while the residual `relative` [1] is above `from` [1]: far from
  /// equilibrium the set oscillates. @return whether it changed
  bool close_contact(StepConstraints<Dim>& constraints, double relative, double from) {
    constexpr int free_contact_changes = 8;  // afterwards only one pair at a time
    if (relative > from) return false;
    const bool careful = outcome_.contact_changes > free_contact_changes;
    const int changes = constraints.update(unknowns_.displacement, work_.residual, careful);
    outcome_.contact_changes += changes > 0 ? 1 : 0;
    return changes > 0;
  }

  /// Assembles and factorises the matrix of the linear problem (57) with the present parameters.
  /// @param step_of_fixed  displacement that the held unknowns still have to make [m]
  [[nodiscard]] bool factorize(std::span<const char> fixed, std::span<const double> step_of_fixed) {
    evaluate(multiplier_law());
    equilibrium_.tangent(work_.stiffness);
    return factorized_ = system_.factorize(fixed, step_of_fixed);
  }

  /// The same after a change of the contact set; the matrix does not change within a step.
  /// @param step_of_fixed  displacement that the held unknowns still have to make [m]
  [[nodiscard]] bool hold(std::span<const char> fixed, std::span<const double> step_of_fixed) {
    if (factorized_ && system_.change(fixed, step_of_fixed)) return true;
    return factorize(fixed, step_of_fixed);
  }

  /// Adds the computed direction to the displacement.
  void advance() {
    for (std::size_t i = 0; i < unknowns_.displacement.size(); ++i) {
      unknowns_.displacement[i] += work_.direction[i];
    }
  }

  /// Keeps the stress deviators of the last residual for the next step.
  void store_deviator() { unknowns_.deviator = equilibrium_.deviators(); }

  const Problem& problem_;
  const Options& options_;
  Workspace& work_;
  StepUnknowns<Dim>& unknowns_;
  Equilibrium<Dim> equilibrium_;
  ConstrainedSystem system_;
  std::vector<double> gamma_p_;     ///< by point [1/(Pa s)]
  std::vector<Tensor> multiplier_;  ///< q by point [1/s]
  StepOutcome outcome_;
  double round_off_;     ///< [N/m in 2D]
  double least_acting_;  ///< [N/m in 2D] least_acting_force() of the problem
  double acting_ = 0.0;  ///< [N/m in 2D] scale of the last residual
  bool factorized_ = false;
  bool settled_ = false;  ///< every increment since it was set passed the paper's test
};

}  // namespace dccast::mechanics
