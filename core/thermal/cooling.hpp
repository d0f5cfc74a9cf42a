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

/// Water on the side: on the wetted share the law of Weckman and Niessen or the table of the case,
/// with the film's temperature and flow, up to the critical heat flux; on the rest the coefficient
/// of the vapour film; in all not more than the film can take. The limits cause kinks, which the
/// semismooth Newton method can handle.
SurfaceFlux water_flux(const Water& water, const WaterPlace& film, const SurfaceState& surface,
                       const SidePlace& place);

/// A cooling zone of the side: the coefficients for liquid and solid surface are weighted by the
/// liquid fraction.
/// @param ambient_temperature  [°C]
SurfaceFlux zone_flux(const SideZone& zone, const SurfaceState& surface, const SidePlace& place,
                      double ambient_temperature);

/// The side outside zones and water.
SurfaceFlux dry_flux(const CoolingSpec& cooling, const SurfaceState& surface);

/// The metal level, if it loses heat to the surroundings.
SurfaceFlux level_flux(const CoolingSpec& cooling, const SurfaceState& surface);

/// What the bottom of the slab faces at one place during one step.
struct BottomPlace {
  double coefficient = 0.0;      ///< [W/(m2 K)] to the block, without the temperature factor
  double block = 0.0;            ///< [°C] of the block's surface at the end, if no heat flowed
  double compliance = 0.0;       ///< [m2 K/W] by which a flux warms the block's surface
  double wet_coefficient = 0.0;  ///< [W/(m2 K)] from slab and from block to water in the gap
  double water = 0.0;            ///< [°C]
};

/// Coefficient of the bottom block without the temperature factor [W/(m2 K)]: contact coefficient
/// against time if the gap is closed, gap coefficient if it is open, linear between contact and the
/// first point of the gap table.
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
