#pragma once

#include "core/thermal/boiling.hpp"
#include "core/thermal/cooling_spec.hpp"

namespace dccast::thermal {

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
};

/// Falling film of water, Weckman and Niessen (1982), their fit for DC casting:
///   q = [-1.67e5 + 352 (T + Tw)] Gamma^(1/3) (T - Tw) + 20.8 <T - 373>^3, T and Tw in K,
/// the second term, nucleate boiling, only above 373 K. The flux is not limited here.
/// @param temperature        T of the surface [°C]
/// @param water_temperature  [°C]
/// @param water_flow         Gamma [m2/s], per metre of perimeter
SurfaceFlux weckman_niessen(double temperature, double water_temperature, double water_flow);

/// Water on the side: the law of Weckman and Niessen or the table of the case, limited by the
/// critical heat flux; under a vapour film the film coefficient. The limit causes a kink, which the
/// semismooth Newton method can handle.
/// @param water_flow  [m2/s] @param film_share  [1] @see thermal::film_share
SurfaceFlux water_flux(const Water& water, const Boiling& boiling, const SurfaceState& surface,
                       const SidePlace& place, double water_flow, double film_share);

/// A cooling zone of the side: the coefficients for liquid and solid surface are weighted by the
/// liquid fraction.
/// @param ambient_temperature  [°C]
SurfaceFlux zone_flux(const SideZone& zone, const SurfaceState& surface, const SidePlace& place,
                      double ambient_temperature);

/// The side outside zones and water.
SurfaceFlux dry_flux(const CoolingSpec& cooling, const SurfaceState& surface);

/// Bottom block: contact coefficient against time if the gap is closed, gap coefficient if it is
/// open, linear between contact and the first point of the gap table; multiplied by the factor for
/// the surface temperature.
/// @param time  [s]
/// @param gap   [m]; zero or less is contact
SurfaceFlux bottom_flux(const BottomBlock& block, const SurfaceState& surface, double time,
                        double gap);

/// Coefficient of the bottom block without the temperature factor [W/(m2 K)].
/// @param time  [s] @param gap  [m]
double bottom_coefficient(const BottomBlock& block, double time, double gap);

}  // namespace dccast::thermal
