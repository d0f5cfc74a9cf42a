#include "core/thermal/cooling.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dccast::thermal {
namespace {

constexpr double stated_subcooling = 75.0;  // [K] of water at 25 °C, for which the laws are stated

double subcooling(const Film& film) {
  return std::max(0.0, boiling_point - film.temperature);
}

/// Relative increase of the critical flux of a jet by subcooling [K], compared to saturated water.
/// Properties of water and steam at 100 °C and 1 bar.
double subcooling_gain(double kelvin) {
  constexpr double density_ratio = 958.4 / 0.598;  // liquid to vapour [1]
  constexpr double specific_heat = 4217.0;         // [J/(kg K)]
  const double share = specific_heat * kelvin / evaporation_heat;
  return 1.0 + 2.7 * std::sqrt(density_ratio) * share * share;
}

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

/// Contact and air gap in series, beside radiation. @param wall  [°C]
SurfaceFlux gap_flux(const SideZone& zone, const SurfaceState& surface, const SidePlace& place,
                     double wall) {
  constexpr double stefan_boltzmann = 5.670374e-8;  // [W/(m2 K4)]
  const MouldGap& gap = *zone.gap;
  const double width = std::max(0.0, place.inward - gap.taper * place.distance);  // [m]

  const double fraction = surface.liquid_fraction, excess = surface.temperature - wall;
  const Coefficient liquid = coefficient(zone.liquid_coefficient, surface.temperature, place);
  const Coefficient solid = coefficient(zone.solid_coefficient, surface.temperature, place);
  const double contact = fraction * liquid.value + (1.0 - fraction) * solid.value;

  // h = contact / (1 + contact g/k), and its derivative by the contact coefficient.
  const double series = 1.0 / (1.0 + contact * width / gap.air_conductivity);
  const double h = contact * series, d_contact = series * series;
  const double d_contact_by_temperature =
      fraction * liquid.d_temperature + (1.0 - fraction) * solid.d_temperature;

  const double hot = surface.temperature - absolute_zero, cold = wall - absolute_zero;
  const double radiation = stefan_boltzmann * gap.emissivity;
  return {h * excess + radiation * (std::pow(hot, 4) - std::pow(cold, 4)),
          h + d_contact * d_contact_by_temperature * excess + 4.0 * radiation * std::pow(hot, 3),
          d_contact * (liquid.value - solid.value) * excess};
}

}  // namespace

double critical_heat_flux(const Water& water, const Film& film, double depth) {
  const Wetting& w = water.wetting;
  return film.critical_factor * water.critical_heat_flux *
         std::pow(film.flow / full_flow, w.flow_exponent) * subcooling_gain(subcooling(film)) /
         subcooling_gain(stated_subcooling) * (depth < w.jet_length ? 1.0 : w.falling_film_share);
}

double rewetting_temperature(const Wetting& w, const Film& film) {
  const double share = 0.25 + 0.75 * subcooling(film) / stated_subcooling;
  return std::min(
      w.rewetting_limit,
      w.rewetting_saturated + w.rewetting_rise * std::sqrt(film.flow / start_flow) * share);
}

double wet_in_the_end(const Wetting& w, double surface_temperature, double rewetting) {
  return 1.0 / (1.0 + std::exp((surface_temperature - rewetting) / w.rewetting_width));
}

double film_coefficient(const Wetting& w, const Film& film, double depth) {
  return (depth < w.jet_length ? w.jet_film_coefficient : w.film_coefficient) *
         std::sqrt(film.flow / start_flow) * (0.3 + 0.7 * subcooling(film) / stated_subcooling);
}

bool is_open(const Water& water, double time) {
  if (!water.enabled || time <= water.start) return false;
  if (water.pulse_period <= 0.0 || time >= water.pulse_end) return true;
  return std::fmod(time - water.start, water.pulse_period) < water.pulse_share * water.pulse_period;
}

std::vector<double> valve_changes(const Water& water, double end, std::size_t most) {
  if (!water.enabled) return {};
  std::vector<double> times{water.start};
  const double last = std::min(end, water.pulse_end);
  if (water.pulse_period <= 0.0 || last <= water.start) return times;

  // Too many pulses would exhaust the memory; the case check reports them.
  const double pulses = (last - water.start) / water.pulse_period;
  if (2.0 * pulses > static_cast<double>(most)) return times;

  for (int i = 0; i < static_cast<int>(std::ceil(pulses)); ++i) {
    const double opens = water.start + i * water.pulse_period;
    times.push_back(opens);
    times.push_back(opens + water.pulse_share * water.pulse_period);
  }

  std::erase_if(times, [last](double t) { return t >= last; });
  times.push_back(last);
  return times;
}

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

SurfaceFlux water_flux(const Water& water, const WaterPlace& film, const SurfaceState& surface,
                       const SidePlace& place) {
  const double temperature = surface.temperature, surroundings = film.film.temperature;
  SurfaceFlux flux = water.coefficient.empty()
                         ? weckman_niessen(temperature, surroundings, film.film.flow)
                         : convection(coefficient(water.coefficient, temperature, place),
                                      temperature, surroundings);

  // Beyond the critical heat flux the surface boils no more strongly.
  if (flux.flux > film.critical_heat_flux) flux = {film.critical_heat_flux, 0.0, 0.0};

  // The part that is not wetted loses heat through a vapour film.
  if (film.wetted < 1.0) {
    const SurfaceFlux vapour = convection({film.film_coefficient, 0.0}, temperature, surroundings);
    const double dry = 1.0 - film.wetted;
    flux = {film.wetted * flux.flux + dry * vapour.flux,
            film.wetted * flux.d_temperature + dry * vapour.d_temperature, 0.0};
  }

  // The stream cannot take more heat than boils it away.
  if (flux.flux > film.largest_flux) flux = {film.largest_flux, 0.0, 0.0};
  return flux;
}

SurfaceFlux zone_flux(const SideZone& zone, const SurfaceState& surface, const SidePlace& place,
                      double ambient_temperature) {
  const double temperature = surface.temperature;
  const double surroundings =
      zone.temperature.empty() ? ambient_temperature : zone.temperature(place.time);

  if (zone.gap) return gap_flux(zone, surface, place, surroundings);

  const SurfaceFlux liquid = convection(coefficient(zone.liquid_coefficient, temperature, place),
                                        temperature, surroundings);
  const SurfaceFlux solid = convection(coefficient(zone.solid_coefficient, temperature, place),
                                       temperature, surroundings);

  // The coefficient depends on the liquid fraction linearly.
  const double fraction = surface.liquid_fraction;
  return {fraction * liquid.flux + (1.0 - fraction) * solid.flux,
          fraction * liquid.d_temperature + (1.0 - fraction) * solid.d_temperature,
          liquid.flux - solid.flux};
}

SurfaceFlux dry_flux(const CoolingSpec& cooling, const SurfaceState& surface) {
  return convection({cooling.dry_coefficient, 0.0}, surface.temperature,
                    cooling.ambient_temperature);
}

SurfaceFlux level_flux(const CoolingSpec& cooling, const SurfaceState& surface) {
  return convection({cooling.level_coefficient, 0.0}, surface.temperature,
                    cooling.ambient_temperature);
}

double bottom_coefficient(const BottomBlock& block, double time, double gap) {
  const double contact = block.contact_coefficient(time - block.first_metal);
  if (gap <= 0.0 || block.gap_coefficient.empty()) return contact;
  const double first = block.gap_coefficient.at().front();
  if (gap >= first) return block.gap_coefficient(gap);
  return contact + (block.gap_coefficient.value().front() - contact) * gap / first;
}

BottomFlux bottom_flux(const BottomBlock& block, const BottomPlace& place,
                       const SurfaceState& surface) {
  const double t = surface.temperature, wet = place.wet_coefficient, r = place.compliance;
  double h = place.coefficient, dh = 0.0;
  if (!block.temperature_factor.empty()) {
    dh = h * block.temperature_factor.derivative(t);
    h *= block.temperature_factor(t);
  }

  // The surface of the block warms with the flux into it, r [m2 K/W]: eliminating its temperature
  // from q = h (t - block_surface) gives the divisor.
  const double divisor = 1.0 + r * (h + wet);
  const double block_surface = (place.block + r * (h * t + wet * place.water)) / divisor;
  const double excess = t - block_surface;
  const double d_block = r * (dh * excess + h) / divisor;
  return {{h * excess + wet * (t - place.water), dh * excess + h * (1.0 - d_block) + wet, 0.0},
          h * excess - wet * (block_surface - place.water)};
}

}  // namespace dccast::thermal
