#pragma once

#include "core/material/alloy_card.hpp"
#include "core/material/norton_hoff.hpp"

namespace dccast::material {

/// What mechanics asks of an alloy at a temperature [°C].
///
/// Outside its range a table of the card is held at its end. Creep, a formula, is held at the liquidus:
/// Arrhenius' factor would go on growing in metal that is no longer solid, which the paper's law says
/// nothing of. It shows with `liquid = "solid"` alone; a liquid element has no creep.
class MechanicalProperties {
public:
  explicit MechanicalProperties(const AlloyCard& card);

  /// Bulk modulus lambda + 2 mu / 3 [Pa].
  double bulk_modulus(double temperature) const;
  /// Shear modulus mu [Pa].
  double shear_modulus(double temperature) const;
  /// [kg/m3]
  double density(double temperature) const { return card_.density(temperature); }
  double liquid_density() const { return liquid_density_; }  ///< rho_l = rho(T_l) [kg/m3]
  /// (rho_l / rho(T))^(1/3): the antiderivative of alpha(T), eq. (11). Differences of it are the
  /// thermal strain between two temperatures, exactly, through the mushy interval as well.
  double thermal_stretch(double temperature) const;
  const NortonHoff& creep() const { return creep_; }
  /// kappa(T) of the creep law, above the liquidus that of the liquidus [Pa^-(q-1)/s].
  double kappa(double temperature) const;
  double coherency() const { return card_.coherency; }  ///< [°C]
  double liquidus() const { return card_.liquidus; }    ///< [°C]
  double solidus() const { return card_.solidus; }      ///< [°C]

private:
  AlloyCard card_;
  NortonHoff creep_;
  double liquid_density_;  ///< [kg/m3]
};

}  // namespace dccast::material
