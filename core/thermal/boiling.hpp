#pragma once

#include <vector>

#include "core/thermal/cooling_spec.hpp"

namespace dccast::thermal {

/// Parameters that limit the boiling of water on a hot surface.
struct Boiling {
  double critical_heat_flux = 0.0;  ///< [W/m2] upper limit of the flux from a wet surface
  double leidenfrost = 0.0;         ///< [°C] above it a vapour film covers the surface
  double film_coefficient = 0.0;    ///< [W/(m2 K)] through the film
};

/// Flow at which Water gives its critical heat flux: that of a steady cast [m2/s].
inline constexpr double full_flow = 3e-3;
/// Flow at which Water gives its Leidenfrost temperature and film coefficient: that of a start
/// [m2/s].
inline constexpr double start_flow = 1.5e-3;

/// The parameters of a case or, with `boiling_follows_flow`, their values at a flow and at the
/// subcooling s = 100 °C - Tw of the water; the case states them at s = 75 K (docs/water.md):
///   critical flux   ~ (flow / full_flow)^(1/3) (1 + 2.7 sqrt(rho_l/rho_v) (c s / h_fg)^2)
///   Leidenfrost - 100 °C  ~ (flow / start_flow) s
///   film coefficient      ~ (flow / start_flow)^(1/2) s
/// The first is the form of Monde and Katto for an impinging jet; the other two are assumptions.
/// @param water_flow  [m2/s], positive
/// @param time        [s], for a water temperature tabulated against time
Boiling boiling_of(const Water& water, double water_flow, double time);

/// Share of the surface under a vapour film, 0 to 1 [1].
///
/// At the Leidenfrost temperature the flux drops with rising temperature; an implicit step would
/// have several solutions. The state of the surface at the *start* of a step therefore determines
/// the share for the whole step, blended over `film_boiling_blend` [K] around the Leidenfrost
/// temperature. With `boiling_follows_flow` a wet surface stays wet up to `film_hysteresis` [K]
/// above it.
/// @param surface_temperature  [°C] at the start of the step
/// @param wetted               water touched the metal in the previous step
double film_share(const Water& water, const Boiling& boiling, double surface_temperature,
                  bool wetted);
inline constexpr double film_boiling_blend = 5.0;  ///< [K] width of the blend
inline constexpr double film_hysteresis = 50.0;    ///< [K] an assumption

/// Whether the valve is open. It is closed before the start; each pulse begins with its open part.
/// @param time  [s]
bool is_open(const Water& water, double time);
/// Times at which the valve opens or closes before `end` [s]; only the start if there are more than
/// `most`. @param end  [s]
std::vector<double> valve_changes(const Water& water, double end, std::size_t most = 1'000'000);

}  // namespace dccast::thermal
