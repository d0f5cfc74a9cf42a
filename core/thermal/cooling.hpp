#pragma once

#include "core/thermal/boiling.hpp"
#include "core/thermal/cooling_spec.hpp"

namespace dccast::thermal {

/// What a cooling law sees of the metal.
struct SurfaceState {
  double temperature = 0.0;      ///< [°C]
  double liquid_fraction = 0.0;  ///< [1]
};

/// Heat that leaves the metal, and how it changes with the surface.
struct SurfaceFlux {
  double flux = 0.0;               ///< [W/m2], positive out of the metal
  double d_temperature = 0.0;      ///< [W/(m2 K)]
  double d_liquid_fraction = 0.0;  ///< [W/m2]
};

/// Where and when a law of the side is evaluated.
struct SidePlace {
  double time = 0.0;      ///< [s]
  double distance = 0.0;  ///< [m] below the metal level
};

/// Falling film of water, Weckman and Niessen (1982), their fit for DC casting:
///   q = [-1.67e5 + 352 (T + Tw)] Gamma^(1/3) (T - Tw) + 20.8 <T - 373>^3, T and Tw in K,
/// the second term, nucleate boiling, only above 373 K. No upper bound here.
/// @param temperature        T of the surface [°C]
/// @param water_temperature  [°C]
/// @param water_flow         Gamma [m2/s], per metre of perimeter
SurfaceFlux weckman_niessen(double temperature, double water_temperature, double water_flow);

/// Water on the side: Weckman and Niessen's law, or the case's table in its place, bounded by the
/// critical heat flux; where a vapour film stands, its coefficient. The bound is a kink, which a
/// semismooth Newton method takes as it is.
/// @param water_flow  [m2/s] @param film_share  [1] @see thermal::film_share
SurfaceFlux water_flux(const Water& water, const Boiling& boiling, const SurfaceState& surface,
                       const SidePlace& place, double water_flow, double film_share);

/// A zone of the side: coefficients of liquid and solid surface mixed by the liquid fraction.
/// @param ambient_temperature  [°C]
SurfaceFlux zone_flux(const SideZone& zone, const SurfaceState& surface, const SidePlace& place,
                      double ambient_temperature);

/// Side outside zones and water.
SurfaceFlux dry_flux(const CoolingSpec& cooling, const SurfaceState& surface);

/// Bottom block: contact coefficient against time where the gap is closed, gap coefficient where it
/// is open, linear between contact and the first point of the gap's table; times the factor by
/// surface temperature.
/// @param gap  [m]; zero or less is contact
SurfaceFlux bottom_flux(const BottomBlock& block, const SurfaceState& surface, double time,
                        double gap);

/// Coefficient of the bottom block before the temperature factor [W/(m2 K)].
double bottom_coefficient(const BottomBlock& block, double time, double gap);

}  // namespace dccast::thermal
