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
  double temperature = 0.0;      ///< [°C], mean over its thickness
  double flow = 0.0;             ///< [m2/s] that is left, per metre of perimeter
  double critical_factor = 1.0;  ///< [1] on the critical heat flux: less with gas in the water
};

/// Limits on the heat that water takes from the metal at one place during one step.
struct WaterPlace {
  Film film;
  double wetted = 1.0;              ///< [1] share that is not under vapour, mean over the step
  double rewetting = 0.0;           ///< [°C] of the surface, @see rewetting_temperature()
  double critical_heat_flux = 0.0;  ///< [W/m2] upper limit of the flux from a wet surface
  double film_coefficient = 0.0;    ///< [W/(m2 K)] through the vapour film
  /// [W/m2] by the heat that the film can still take
  double largest_flux = std::numeric_limits<double>::infinity();
  double wall_flux = 0.0;  ///< [W/m2] into the film from another wall beside it
};

/// Flow at which Water gives its critical heat flux: that of a steady cast [m2/s].
inline constexpr double full_flow = 3e-3;
/// Flow at which Wetting gives its rewetting temperature and vapour-film coefficients: that of a
/// start [m2/s].
inline constexpr double start_flow = 1.5e-3;

/// Critical flux [W/m2] of the film: its factor times that of the case at `full_flow` and 75 K of
/// subcooling s times
///   (flow / full_flow)^n (1 + 2.7 sqrt(rho_l/rho_v) (c s / h_fg)^2) / the same at 75 K
/// (Monde and Katto's form for an impinging jet), and times the share of the falling film below the
/// jet.
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

/// Whether the valve is open. It is closed before the start; each pulse begins with its open part.
/// @param time  [s]
bool is_open(const Water& water, double time);
/// Times at which the valve opens or closes before `end` [s]; only the start if there are more than
/// `most`. @param end  [s]
std::vector<double> valve_changes(const Water& water, double end, std::size_t most = 1'000'000);

/// State of the metal surface, input of a cooling law.
struct SurfaceState {
  double temperature = 0.0;      ///< [°C]
  double liquid_fraction = 0.0;  ///< [1]
};

/// Heat flux out of the metal and its derivatives by the state of the surface.
struct SurfaceFlux {
  double flux = 0.0;               ///< [W/m2], positive out of the metal
  double d_temperature = 0.0;      ///< [W/(m2 K)]
  double d_liquid_fraction = 0.0;  ///< [W/m2]
};

/// Time and place at which a cooling law of the side is evaluated.
struct SidePlace {
  double time = 0.0;      ///< [s]
  double distance = 0.0;  ///< [m] below the metal level
  double inward = 0.0;    ///< [m] displacement of the face away from the mould
};

/// Falling film of water, Weckman and Niessen (1982), their fit for DC casting:
///   q = [-1.67e5 + 352 (T + Tw)] Gamma^(1/3) (T - Tw) + 20.8 <T - 373>^3, T and Tw in K,
/// the second term, nucleate boiling, only above 373 K. The flux is not limited here.
/// @param temperature        T of the surface [°C]
/// @param water_temperature  [°C]
/// @param water_flow         Gamma [m2/s], per metre of perimeter
SurfaceFlux weckman_niessen(double temperature, double water_temperature, double water_flow);

/// Water on the side: on the wetted share the law of Weckman and Niessen or the table of the case,
/// with the film's temperature and flow, up to the critical heat flux; on the rest the coefficient
/// of the vapour film; in all not more than the film can take. The limits cause kinks, which the
/// semismooth Newton method can handle.
SurfaceFlux water_flux(const Water& water, const WaterPlace& film, const SurfaceState& surface,
                       const SidePlace& place);

/// A cooling zone of the side: the coefficients for liquid and solid surface are weighted by the
/// liquid fraction. With a gap g to the wall, by which the face has moved inward more than the wall
/// closes in (taper times distance), h of the mixture is that of contact, and
///   q = (T - T_w) / (1/h + g/k) + sigma epsilon (T^4 - T_w^4), T in K in the second term.
/// @param ambient_temperature  [°C]
SurfaceFlux zone_flux(const SideZone& zone, const SurfaceState& surface, const SidePlace& place,
                      double ambient_temperature);

/// The side outside zones and water.
SurfaceFlux dry_flux(const CoolingSpec& cooling, const SurfaceState& surface);

/// The metal level, if it loses heat to the surroundings.
SurfaceFlux level_flux(const CoolingSpec& cooling, const SurfaceState& surface);

/// Surroundings of the bottom of the slab at one place during one step.
struct BottomPlace {
  double coefficient = 0.0;      ///< [W/(m2 K)] to the block, without the temperature factor
  double block = 0.0;            ///< [°C] of the block's surface at the end, if no heat flowed
  double compliance = 0.0;       ///< [m2 K/W] by which a flux warms the block's surface
  double wet_coefficient = 0.0;  ///< [W/(m2 K)] from slab and from block to water in the gap
  double water = 0.0;            ///< [°C]
};

/// Coefficient of the bottom block without the temperature factor [W/(m2 K)]: contact coefficient
/// against the time since the first metal if the gap is closed, gap coefficient if it is open,
/// linear between contact and the first point of the gap table.
/// @param time  [s] @param gap  [m]; zero or less is contact
double bottom_coefficient(const BottomBlock& block, double time, double gap);

/// Heat between slab, block and water in the gap.
struct BottomFlux {
  SurfaceFlux slab;         ///< out of the slab
  double into_block = 0.0;  ///< [W/m2]
};

/// With H the coefficient times the factor for the surface temperature, W that of the water:
///   q = H (T - T_b) + W (T - T_w),   T_b = block + compliance (H (T - T_b) - W (T_b - T_w)).
BottomFlux bottom_flux(const BottomBlock& block, const BottomPlace& place,
                       const SurfaceState& surface);

}  // namespace dccast::thermal
