#include "core/thermal/boiling.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::thermal {
namespace {

constexpr double stated_subcooling = 75.0;  // [K] of water of 25 °C

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

}  // namespace

double critical_heat_flux(const Water& water, const Film& film, double depth) {
  const Wetting& w = water.wetting;
  return water.critical_heat_flux * std::pow(film.flow / full_flow, w.flow_exponent) *
         subcooling_gain(subcooling(film)) / subcooling_gain(stated_subcooling) *
         (depth < w.jet_length ? 1.0 : w.falling_film_share);
}

double rewetting_temperature(const Wetting& w, const Film& film) {
  const double share = 0.25 + 0.75 * subcooling(film) / stated_subcooling;
  return std::min(w.rewetting_limit, w.rewetting_saturated + w.rewetting_rise *
                                                                 std::sqrt(film.flow / start_flow) *
                                                                 share);
}

double wet_in_the_end(const Wetting& w, double surface_temperature, double rewetting) {
  return 1.0 / (1.0 + std::exp((surface_temperature - rewetting) / w.rewetting_width));
}

double film_coefficient(const Wetting& w, const Film& film, double depth) {
  return (depth < w.jet_length ? w.jet_film_coefficient : w.film_coefficient) *
         std::sqrt(film.flow / start_flow) * (0.3 + 0.7 * subcooling(film) / stated_subcooling);
}

double fixed_film_share(const Water& water, double surface_temperature) {
  constexpr double blend = 5.0;  // [K]
  if (!water.film_boiling) return 0.0;
  return std::clamp((surface_temperature - water.film_boiling_above) / blend + 0.5, 0.0, 1.0);
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

}  // namespace dccast::thermal
