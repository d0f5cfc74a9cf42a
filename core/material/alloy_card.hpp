#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <variant>

#include "core/base/curve.hpp"

namespace dccast::material {

/// A figure that the case does not give. The check of the case reports it where a law needs it.
inline constexpr double not_given = std::numeric_limits<double>::quiet_NaN();
inline bool is_given(double figure) {
  return !std::isnan(figure);
}

/// Creep constants as the paper prints them, eq. (16) and (20).
struct NortonHoffConstants {
  double material_resistance = not_given;  ///< lambda_r [Pa/s]
  double shear_limit = not_given;          ///< k [Pa]
  double activation_energy = not_given;    ///< G [J/mol]
  double exponent = not_given;             ///< q [1]
};

/// Creep law given by one uniaxial test.
struct ReferenceCreep {
  double stress = not_given;             ///< [Pa]
  double strain_rate = not_given;        ///< [1/s]
  double temperature = not_given;        ///< [°C]
  double stress_exponent = not_given;    ///< q - 1 [1]
  double activation_energy = not_given;  ///< [J/mol]
};

/// How metal behaves between its coherency and the end of freezing. Without this law the mush is
/// the paper's: as strong as the solid at its temperature, and contracting with the mixture's
/// density.
struct MushLaw {
  /// [1] solid fraction at which the grains have grown together: the skeleton contracts and resists
  /// as a whole, and melt no longer flows through it
  double coalescence = 1.0;
  /// [1] a of the strength exp(-a (1 - fs)) relative to the solid, once the grains have grown
  /// together
  double strength_decay = 0.0;
  /// [1] 0 to 1: share of the shrinkage after coalescence that strains the skeleton; the rest
  /// becomes pores
  double unfed_strain_share = 0.0;
};

/// Limit of the stress in cold metal, whose strain rate no longer matters. The yield stress is
/// Y(T) [1 + w(T) ((1 + e / e0)^(1/4) - 1)], where e is the equivalent viscoplastic strain gained
/// since solidification at temperatures with w > 0.
struct ColdStrength {
  Curve yield_stress;  ///< Y [Pa] against temperature, without hardening
  Curve hardening;     ///< w [1] against temperature: 1 cold, 0 where hardening recovers at once
};

/// Where the alloy tears while it freezes, and the arm spacing of its dendrites, between which melt
/// feeds the mush.
struct HotTearWindow {
  double start = 0.0, end = 0.0;  ///< [1] solid fractions; no window unless end > start
  double arm_spacing = 0.0;       ///< [m]; 0: no pressure drop is computed
};

/// The tables of an alloy: table `alloy` of a case, completed from its card. Curves are functions
/// of temperature [°C] unless stated otherwise, constant outside their range. Creep is a formula;
/// above the liquidus its value at the liquidus is used (MechanicalProperties::kappa).
struct AlloyCard {
  std::string name;
  double liquidus = not_given;   ///< [°C]
  double solidus = not_given;    ///< [°C]; equal to the liquidus for a pure metal
  double coherency = not_given;  ///< [°C] below it the mush transmits stress
  /// [°C] below it metal holds melt back and is a shell, which the mould releases; absent: the
  /// solidus
  std::optional<double> shell;
  double latent_heat = not_given;  ///< [J/kg]
  Curve density;                   ///< [kg/m3] of the mixture of solid and liquid
  /// [kg/m3] of a fixed volume when feeding ends: all its metal stores heat. Absent: the density at
  /// its temperature, as in the paper (ThermalProperties).
  std::optional<double> fed_density;
  /// [kg/m3] of the solid alone, up to the liquidus; empty: the density below the solidus,
  /// continued
  Curve solid_density;
  Curve specific_heat;             ///< [J/(kg K)]
  Curve conductivity;              ///< [W/(m K)]
  Curve melt_conductivity_factor;  ///< [1] against liquid fraction
  /// [1] from 0 at the solidus to 1 at the liquidus, never falling; empty: linear
  Curve liquid_fraction;
  Curve young_modulus;  ///< [Pa]
  Curve poisson_ratio;  ///< [1]
  std::variant<NortonHoffConstants, ReferenceCreep> creep;
  std::optional<MushLaw> mush;                ///< absent: the paper's mush
  std::optional<ColdStrength> cold_strength;  ///< absent: creep alone limits the stress
  HotTearWindow hot_tears;

  double shell_temperature() const { return shell.value_or(solidus); }  ///< [°C]
};

}  // namespace dccast::material
