#pragma once

#include <limits>
#include <vector>

#include "core/thermal/cooling_spec.hpp"

namespace dccast::thermal {

/// Density [kg/m3], specific heat [J/(kg K)], heat of evaporation [J/kg] and boiling point [°C] of
/// water at 1 bar.
inline constexpr double water_density = 1000.0;
inline constexpr double water_specific_heat = 4190.0;
inline constexpr double evaporation_heat = 2.257e6;
inline constexpr double boiling_point = 100.0;

/// The water film at one place of a face.
struct Film {
  double temperature = 0.0;  ///< [°C], mean over its thickness
  double flow = 0.0;         ///< [m2/s] that is left, per metre of perimeter
};

/// What limits the heat that water takes from the metal at one place during one step.
struct WaterPlace {
  Film film;
  double wetted = 1.0;              ///< [1] share that is not under vapour, mean over the step
  double rewetting = 0.0;           ///< [°C] of the surface, @see rewetting_temperature()
  double critical_heat_flux = 0.0;  ///< [W/m2] upper limit of the flux from a wet surface
  double film_coefficient = 0.0;    ///< [W/(m2 K)] through the vapour film
  /// [W/m2] by the heat that the film can still take
  double largest_flux = std::numeric_limits<double>::infinity();
};

/// Flow at which Water gives its critical heat flux: that of a steady cast [m2/s].
inline constexpr double full_flow = 3e-3;
/// Flow at which Wetting gives its rewetting temperature and vapour-film coefficients: that of a
/// start [m2/s].
inline constexpr double start_flow = 1.5e-3;

/// Critical flux [W/m2] of the film: that of the case at `full_flow` and 75 K of subcooling s, times
///   (flow / full_flow)^n (1 + 2.7 sqrt(rho_l/rho_v) (c s / h_fg)^2) / the same at 75 K
/// (Monde and Katto's form for an impinging jet), times the share of the falling film below the jet.
/// @param depth  [m] below the water line
double critical_heat_flux(const Water& water, const Film& film, double depth);

/// Surface temperature at which half of the surface is wet [°C]; an assumption, docs/water.md:
///   min(limit, W0 + W1 (flow / start_flow)^(1/2) (1/4 + 3/4 s / 75 K)).
double rewetting_temperature(const Wetting& wetting, const Film& film);

/// Share of a surface [1] that is wet after a long time, 1 / (1 + exp((T - T_w) / width)).
/// @param surface_temperature  T [°C] @param rewetting  T_w [°C]
double wet_in_the_end(const Wetting& wetting, double surface_temperature, double rewetting);

/// Coefficient of the vapour film [W/(m2 K)], as the flow and the subcooling:
///   h (flow / start_flow)^(1/2) (0.3 + 0.7 s / 75 K). @param depth  [m] below the water line
double film_coefficient(const Wetting& wetting, const Film& film, double depth);

/// Share of the surface under a vapour film [1] where the case fixes the temperature above which it
/// stands. An implicit step would have several solutions there; so the surface temperature at the
/// start of a step decides, blended over 5 K. @param surface_temperature  [°C]
double fixed_film_share(const Water& water, double surface_temperature);

/// Whether the valve is open. It is closed before the start; each pulse begins with its open part.
/// @param time  [s]
bool is_open(const Water& water, double time);
/// Times at which the valve opens or closes before `end` [s]; only the start if there are more than
/// `most`. @param end  [s]
std::vector<double> valve_changes(const Water& water, double end, std::size_t most = 1'000'000);

}  // namespace dccast::thermal
