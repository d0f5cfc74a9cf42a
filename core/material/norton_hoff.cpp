#include "core/material/norton_hoff.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::material {

namespace {

// R of numerics.md 1.2, 1.987e-3 kcal/(mol K), in joule (thermochemical calorie, 4184 J/kcal).
constexpr double printed_gas_constant = 1.987e-3 * 4184.0;  // [J/(mol K)]
constexpr double gas_constant = 8.314462618;                // [J/(mol K)], CODATA 2018
constexpr double celsius_zero = 273.15;                     // [K]
constexpr double plane_factor = 2.0 / 3.0;                  // s_11 of unit uniaxial tension

NortonHoff from(const NortonHoffConstants& c) {
  NortonHoff law;
  law.factor =
      c.material_resistance / std::pow(std::sqrt(2.0) * c.shear_limit, c.exponent);  // (16)
  law.activation_temperature = c.activation_energy / printed_gas_constant;
  law.exponent = c.exponent;
  return law;
}

NortonHoff from(const ReferenceCreep& c) {
  NortonHoff law;
  law.exponent = c.stress_exponent + 1.0;
  law.activation_temperature = c.activation_energy / gas_constant;
  law.zero_offset = celsius_zero;
  // In uniaxial tension s_11 = 2/3 sigma and |s| = sqrt(2/3) sigma.
  const double kappa =
      c.strain_rate /
      (plane_factor * c.stress * std::pow(std::sqrt(plane_factor) * c.stress, law.exponent - 2.0));
  law.factor = kappa * std::exp(law.activation_temperature / (c.temperature + law.zero_offset));
  return law;
}

}  // namespace

NortonHoff norton_hoff(const AlloyCard& card) {
  return std::visit([](const auto& constants) { return from(constants); }, card.creep);
}

double NortonHoff::kappa(double temperature) const {
  return factor * std::exp(-activation_temperature / (temperature + zero_offset));
}

double creep_power(double norm, double exponent) {
  // pow costs ten times as much. q = 6 is the paper's exponent, q = 4 that of Al-Mg.
  if (exponent == 4.0) return norm * norm;
  if (exponent == 6.0) {
    const double square = norm * norm;
    return square * square;
  }
  return std::pow(norm, exponent - 2.0);
}

ReturnMap return_map(double trial_norm, double creep, double exponent) {
  if (trial_norm <= 0.0) return {0.0, 1.0};

  const double m = exponent - 1.0;
  const double strength = creep * creep_power(trial_norm, exponent);  // c R^(q-2)
  if (strength < 1e-18) return {trial_norm, 1.0};

  // Upper bound of the root: x = R if creep is weak, and (R / c)^(1/m) if it is strong.
  double x = strength <= 1.0 ? trial_norm : trial_norm * std::pow(strength, -1.0 / m);

  // Newton's method on the convex function x + c x^(q-1) - R descends monotonically from there.
  double slope = 1.0;
  constexpr int most = 60;
  for (int i = 0; i < most; ++i) {
    const double power = creep * creep_power(x, exponent);
    slope = 1.0 + m * power;
    const double step = (x + power * x - trial_norm) / slope;
    x -= step;
    if (std::abs(step) <= 1e-15 * trial_norm) break;
  }

  return {x, 1.0 / (1.0 + m * creep * creep_power(x, exponent))};
}

ReturnMap return_map(double trial_norm, double creep, double exponent, double second) {
  const double square = second * second;
  const double linear = creep * std::pow(square, 0.5 * exponent - 1.0);  // c r^(q-2)
  if (linear == 0.0) return return_map(trial_norm, creep, exponent);

  // The root lies below the roots with either stress alone. Newton's method falls from there.
  double x = std::min(return_map(trial_norm, creep, exponent).norm, trial_norm / (1.0 + linear));
  double slope = 1.0;
  constexpr int most = 60;
  for (int i = 0; i < most; ++i) {
    const double sum = x * x + square;
    const double rate = creep * std::pow(sum, 0.5 * exponent - 1.0);
    slope = 1.0 + rate * (1.0 + (exponent - 2.0) * x * x / sum);
    const double step = (x * (1.0 + rate) - trial_norm) / slope;
    x -= step;
    if (std::abs(step) <= 1e-15 * trial_norm) break;
  }
  return {x, 1.0 / slope};
}

double mean_stress_like(double norm, double ratio, double exponent) {
  return norm * std::pow(ratio, -1.0 / (exponent + 1.0));
}

double porous_ratio(double porosity, double exponent) {
  if (porosity <= 0.0) return 0.0;
  const double n = exponent;
  const double sphere = n * (std::pow(porosity, -1.0 / n) - 1.0);
  return std::pow(1.5, 0.5 * (n + 1.0)) * std::pow(sphere, -n);
}

double yosida_root(double load, double exponent) {
  if (load < 1e-18) return 1.0 + load;
  const double m = exponent - 1.0;
  double eta = 1.0 + (load < 1.0 ? load : std::pow(load, 1.0 / m));
  constexpr int most = 60;
  for (int i = 0; i < most; ++i) {
    const double power = creep_power(eta, exponent);  // eta^(q-2)
    const double slope = m * power - (exponent - 2.0) * power / eta;
    const double step = (power * (eta - 1.0) - load) / slope;
    eta -= step;
    if (std::abs(step) <= 1e-15 * eta) break;
  }
  return eta;
}

}  // namespace dccast::material
