#pragma once

#include <algorithm>
#include <cmath>

#include "core/material/alloy_card.hpp"
#include "core/material/norton_hoff.hpp"

namespace dccast::material {

/// Mechanical properties of an alloy. Units: temperatures in all functions [°C].
///
/// Outside their range the tables of the card are constant. Creep is a formula; above the liquidus
/// its value at the liquidus is used: the Arrhenius factor would keep growing in metal that is no
/// longer solid, for which the paper's law is not meant. This matters with `liquid = "solid"` only;
/// a liquid element has no creep.
class MechanicalProperties {
public:
  explicit MechanicalProperties(const AlloyCard& card)
      : card_(card), creep_(norton_hoff(card)), liquid_density_(card.density(card.liquidus)) {}

  /// Bulk modulus lambda + 2 mu / 3 [Pa].
  double bulk_modulus(double temperature) const {
    return card_.young_modulus(temperature) /
           (3.0 * (1.0 - 2.0 * card_.poisson_ratio(temperature)));
  }
  /// Shear modulus mu [Pa].
  double shear_modulus(double temperature) const {
    return card_.young_modulus(temperature) / (2.0 * (1.0 + card_.poisson_ratio(temperature)));
  }
  /// [kg/m3]
  double density(double temperature) const { return card_.density(temperature); }
  double liquid_density() const { return liquid_density_; }  ///< rho_l = rho(T_l) [kg/m3]
  /// Thermal stretch (rho_l / rho(T))^(1/3) [1]: the antiderivative of alpha(T), eq. (11). Its
  /// difference between two temperatures is exactly the thermal strain, also through the mushy
  /// interval.
  double thermal_stretch(double temperature) const {
    return std::cbrt(liquid_density_ / card_.density(temperature));
  }
  const NortonHoff& creep() const { return creep_; }
  /// kappa(T) of the creep law [Pa^-(q-1)/s]; above the liquidus its value at the liquidus.
  double kappa(double temperature) const {
    return creep_.kappa(std::min(temperature, card_.liquidus));
  }
  double coherency() const { return card_.coherency; }        ///< [°C]
  double liquidus() const { return card_.liquidus; }          ///< [°C]
  double shell() const { return card_.shell_temperature(); }  ///< [°C] below it the mould releases

private:
  AlloyCard card_;
  NortonHoff creep_;
  double liquid_density_;  ///< [kg/m3]
};

}  // namespace dccast::material
