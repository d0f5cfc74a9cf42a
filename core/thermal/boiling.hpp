#pragma once

#include <vector>

#include "core/thermal/cooling_spec.hpp"

namespace dccast::thermal {

/// The points that bound the boiling of water on a hot face.
struct Boiling {
  double critical_heat_flux = 0.0;  ///< [W/m2] no wet surface gives more
  double leidenfrost = 0.0;         ///< [°C] above it a vapour film stands
  double film_coefficient = 0.0;    ///< [W/(m2 K)] through the film
};

/// Where Water states its critical heat flux: the flow of a steady cast [m2/s].
inline constexpr double full_flow = 3e-3;
/// Where Water states Leidenfrost temperature and film: the flow of a start [m2/s].
inline constexpr double start_flow = 1.5e-3;

/// The points of a case, or, with `boiling_follows_flow`, moved with the flow and with the
/// subcooling s = 100 °C - Tw of the water, 75 K where the case states them; docs/water.md:
///   critical flux   ~ (flow / full_flow)^(1/3) (1 + 2.7 sqrt(rho_l/rho_v) (c s / h_fg)^2)
///   Leidenfrost - 100 °C  ~ (flow / start_flow) s
///   film coefficient      ~ (flow / start_flow)^(1/2) s
/// The first is the form of Monde and Katto for an impinging jet; the other two are assumptions.
/// @param water_flow  [m2/s], positive
/// @param time        [s] against which the water's temperature may be given
Boiling boiling_of(const Water& water, double water_flow, double time);

/// Share of the surface under a vapour film, 0 to 1.
///
/// The film's collapse is a jump of the flux downwards with rising temperature: taken implicitly it
/// has several solutions. So the state of the surface at the *start* of a step decides it for the
/// step, blended over `film_boiling_blend` [K] around the Leidenfrost temperature. A surface that
/// was wet stays so up to `film_hysteresis` [K] above it; only with `boiling_follows_flow`.
/// @param surface_temperature  [°C] at the start of the step
/// @param wetted               the water touched the metal in the step before
double film_share(const Water& water, const Boiling& boiling, double surface_temperature,
                  bool wetted);
inline constexpr double film_boiling_blend = 5.0;  ///< [K] width of the blend
inline constexpr double film_hysteresis = 50.0;    ///< [K] an assumption

/// Whether the valve is open: after the start, and in a pulse, which begins with its open part.
/// @param time  [s]
bool is_open(const Water& water, double time);
/// Times at which the valve opens or closes before `end` [s]; nothing else than the start where
/// there are more than `most`.
std::vector<double> valve_changes(const Water& water, double end, std::size_t most = 1'000'000);

}  // namespace dccast::thermal
