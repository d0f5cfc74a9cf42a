#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "core/material/alloy_card.hpp"
#include "core/material/norton_hoff.hpp"

namespace dccast::material {

/// Creep of metal at one temperature. In the mush the skeleton creeps in volume too, driven by its
/// mean stress beyond the pressure of the melt in its pores.
struct CreepFactors {
  double deviatoric = 0.0;  ///< kappa of eq. (21) [Pa^-(q-1)/s]
  /// The rate of dilatation is this times (p^2 + r^2)^((q-2)/2) p [Pa^-(q-1)/s].
  double volumetric = 0.0;
  double linear_below = 0.0;  ///< r: the dilatation is linear in a smaller |p| [Pa]
};

/// Limit of the deviator's norm |s| = sqrt(2/3) Y in cold metal; @see ColdStrength.
struct YieldLimit {
  double norm = 0.0;       ///< sqrt(2/3) Y(T), without hardening [Pa]
  double hardening = 0.0;  ///< w(T) [1]
};

/// Mechanical properties of an alloy. Units: temperatures in all functions [°C].
///
/// Outside their range the tables of the card are constant. Creep is a formula; above the liquidus
/// its value at the liquidus is used: the Arrhenius factor would keep growing in metal that is no
/// longer solid, for which the paper's law is not meant. This matters with `liquid = "solid"` only;
/// a liquid element has no creep.
///
/// The laws of the mush are explained in docs/mush.md.
class MechanicalProperties {
public:
  /// @param card  checked; the tables of the mush are computed from it
  explicit MechanicalProperties(const AlloyCard& card);

  /// Bulk modulus lambda + 2 mu / 3 [Pa].
  double bulk_modulus(double temperature) const {
    return card_.young_modulus(temperature) /
           (3.0 * (1.0 - 2.0 * card_.poisson_ratio(temperature)));
  }
  /// Shear modulus mu [Pa].
  double shear_modulus(double temperature) const {
    return card_.young_modulus(temperature) / (2.0 * (1.0 + card_.poisson_ratio(temperature)));
  }
  /// Density of the mixture of solid and liquid [kg/m3].
  double density(double temperature) const { return card_.density(temperature); }
  double liquid_density() const { return liquid_density_; }  ///< rho_l = rho(T_l) [kg/m3]

  /// Thermal stretch [1]; its difference between two temperatures is the thermal strain. With the
  /// paper's mush it is (rho_l / rho(T))^(1/3), the antiderivative of alpha(T), eq. (11). With a
  /// mush law its derivative is psi(fs) alpha_solid(T): melt that freezes is fed or leaves pores,
  /// and does not pull on the skeleton (Stangeland, Mo and others 2004).
  double thermal_stretch(double temperature) const;

  /// Share psi of the grain boundaries that are bridged [1]: 0 at coherency, 1 from coalescence on,
  /// linear in the solid fraction between them. It scales contraction and strength of the mush.
  double bridged_share(double temperature) const;
  /// Strength relative to the solid at the same temperature and strain rate [1].
  double relative_strength(double temperature) const;
  /// Volume of the pores that freezing leaves, per volume of metal [1].
  double pore_share(double temperature) const;

  const NortonHoff& creep() const { return creep_; }
  /// Above the liquidus the values at the liquidus.
  CreepFactors creep_factors(double temperature) const;

  bool has_yield_limit() const { return card_.cold_strength.has_value(); }
  /// @pre has_yield_limit()
  YieldLimit yield_limit(double temperature) const;

  double coherency() const { return card_.coherency; }        ///< [°C]
  double liquidus() const { return card_.liquidus; }          ///< [°C]
  double shell() const { return card_.shell_temperature(); }  ///< [°C]
  double coalescence() const { return coalescence_; }         ///< [°C]

private:
  /// Thermal stretch of the solid alone at a temperature, without the mush [1].
  double solid_stretch(double temperature) const;
  /// Loss of volume since coalescence that the contraction of the solid does not explain [1].
  double unfed_shrinkage(double temperature) const;
  /// Integrates the contraction of the mush, psi dS_solid, from coalescence to coherency.
  void tabulate_mush();

  AlloyCard card_;
  NortonHoff creep_;
  double liquid_density_;     ///< [kg/m3]
  double reference_density_;  ///< [kg/m3] at which the stretch of the solid is 1
  double onset_;              ///< [1] solid fraction at coherency
  double coalescence_;        ///< [°C], not above the coherency
  Curve mush_stretch_;        ///< [1] against temperature, from coalescence to coherency
};

}  // namespace dccast::material
