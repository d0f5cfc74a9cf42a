#pragma once

#include <optional>
#include <string>
#include <variant>

#include "core/base/curve.hpp"

namespace dccast::material {

/// Creep constants as the paper prints them, eq. (16) and (20).
struct NortonHoffConstants {
  double material_resistance = 0.0;  ///< lambda_r [Pa/s]
  double shear_limit = 0.0;          ///< k [Pa]
  double activation_energy = 0.0;    ///< G [J/mol]
  double exponent = 2.0;             ///< q [1]
};

/// Creep law given by one uniaxial test.
struct ReferenceCreep {
  double stress = 0.0;             ///< [Pa]
  double strain_rate = 0.0;        ///< [1/s]
  double temperature = 0.0;        ///< [°C]
  double stress_exponent = 1.0;    ///< q - 1 [1]
  double activation_energy = 0.0;  ///< [J/mol]
};

/// The tables of an alloy: table `alloy` of a case, completed from its card. Curves are functions
/// of temperature [°C] unless stated otherwise, constant outside their range. Creep is a formula;
/// above the liquidus its value at the liquidus is used (MechanicalProperties::kappa).
struct AlloyCard {
  std::string name;
  double liquidus = 0.0;           ///< [°C]
  double solidus = 0.0;            ///< [°C]; equal to the liquidus for a pure metal
  double coherency = 0.0;          ///< [°C] below it the mush transmits stress
  /// [°C] below it metal counts as a shell, and the mould releases it; absent: the solidus
  std::optional<double> shell;
  double latent_heat = 0.0;        ///< [J/kg]
  Curve density;                   ///< [kg/m3]
  Curve specific_heat;             ///< [J/(kg K)]
  Curve conductivity;              ///< [W/(m K)]
  Curve melt_conductivity_factor;  ///< [1] against liquid fraction
  /// [1] from 0 at the solidus to 1 at the liquidus, never falling; empty: linear
  Curve liquid_fraction;
  Curve young_modulus;  ///< [Pa]
  Curve poisson_ratio;  ///< [1]
  std::variant<NortonHoffConstants, ReferenceCreep> creep;

  double shell_temperature() const { return shell.value_or(solidus); }  ///< [°C]
};

}  // namespace dccast::material
