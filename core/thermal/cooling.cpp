#include "core/thermal/cooling.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dccast::thermal {
namespace {

constexpr double absolute_zero = -273.15;  // [°C]

/// A coefficient and its derivative with respect to the surface temperature.
struct Coefficient {
  double value = 0.0;
  double d_temperature = 0.0;
};

Coefficient coefficient(const Curve& curve, double temperature, const SidePlace& place) {
  if (curve.constant()) return {curve.value().front(), 0.0};
  switch (curve.abscissa()) {
    case Abscissa::time:
      return {curve(place.time), 0.0};
    case Abscissa::distance:
      return {curve(place.distance), 0.0};
    case Abscissa::temperature:
      return {curve(temperature), curve.derivative(temperature)};
    default:
      throw std::logic_error(
          "a coefficient of the side stands against time, distance or temperature");
  }
}

/// h (T - T_surroundings)
SurfaceFlux convection(Coefficient h, double temperature, double surroundings) {
  const double excess = temperature - surroundings;
  return {h.value * excess, h.value + h.d_temperature * excess, 0.0};
}

}  // namespace

SurfaceFlux weckman_niessen(double temperature, double water_temperature, double water_flow) {
  const double surface = temperature - absolute_zero;
  const double water = water_temperature - absolute_zero;
  const double film = std::cbrt(water_flow);
  const double convective = -1.67e5 + 352.0 * (surface + water);
  const double excess = surface - water;
  const double boiling = std::max(surface - 373.0, 0.0);  // the law's own 373, not 373.15
  return {convective * film * excess + 20.8 * boiling * boiling * boiling,
          film * (convective + 352.0 * excess) + 3.0 * 20.8 * boiling * boiling, 0.0};
}

SurfaceFlux water_flux(const Water& water, const Boiling& boiling, const SurfaceState& surface,
                       const SidePlace& place, double water_flow, double film_share) {
  const double temperature = surface.temperature;
  const double surroundings = water.temperature(place.time);
  SurfaceFlux wet = water.coefficient.empty()
                        ? weckman_niessen(temperature, surroundings, water_flow)
                        : convection(coefficient(water.coefficient, temperature, place),
                                     temperature, surroundings);
  if (wet.flux > boiling.critical_heat_flux) wet = {boiling.critical_heat_flux, 0.0, 0.0};
  if (film_share <= 0.0) return wet;
  const SurfaceFlux film = convection({boiling.film_coefficient, 0.0}, temperature, surroundings);
  return {(1.0 - film_share) * wet.flux + film_share * film.flux,
          (1.0 - film_share) * wet.d_temperature + film_share * film.d_temperature, 0.0};
}

SurfaceFlux zone_flux(const SideZone& zone, const SurfaceState& surface, const SidePlace& place,
                      double ambient_temperature) {
  const double temperature = surface.temperature;
  const double surroundings =
      zone.temperature.empty() ? ambient_temperature : zone.temperature(place.time);
  const SurfaceFlux liquid = convection(coefficient(zone.liquid_coefficient, temperature, place),
                                        temperature, surroundings);
  const SurfaceFlux solid = convection(coefficient(zone.solid_coefficient, temperature, place),
                                       temperature, surroundings);
  const double fraction = surface.liquid_fraction;
  return {fraction * liquid.flux + (1.0 - fraction) * solid.flux,
          fraction * liquid.d_temperature + (1.0 - fraction) * solid.d_temperature,
          liquid.flux - solid.flux};
}

SurfaceFlux dry_flux(const CoolingSpec& cooling, const SurfaceState& surface) {
  return convection({cooling.dry_coefficient, 0.0}, surface.temperature,
                    cooling.ambient_temperature);
}

double bottom_coefficient(const BottomBlock& block, double time, double gap) {
  const double contact = block.contact_coefficient(time);
  if (gap <= 0.0 || block.gap_coefficient.empty()) return contact;
  const double first = block.gap_coefficient.at().front();
  if (gap >= first) return block.gap_coefficient(gap);
  return contact + (block.gap_coefficient.value().front() - contact) * gap / first;
}

SurfaceFlux bottom_flux(const BottomBlock& block, const SurfaceState& surface, double time,
                        double gap) {
  const double temperature = surface.temperature;
  Coefficient h{bottom_coefficient(block, time, gap), 0.0};
  if (!block.temperature_factor.empty()) {
    h.d_temperature = h.value * block.temperature_factor.derivative(temperature);
    h.value *= block.temperature_factor(temperature);
  }
  return convection(h, temperature, block.temperature(time));
}

}  // namespace dccast::thermal
