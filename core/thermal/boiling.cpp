#include "core/thermal/boiling.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::thermal {
namespace {

constexpr double boiling_point = 100.0;     // [°C]
constexpr double stated_subcooling = 75.0;  // [K] of water of 25 °C, Water's default

/// Relative increase of the critical flux of a jet by subcooling [K], compared to saturated water;
/// Monde and Katto. Properties of water and steam at 100 °C and 1 bar.
double subcooling_gain(double subcooling) {
  constexpr double density_ratio = 958.4 / 0.598;                  // liquid to vapour [1]
  constexpr double specific_heat = 4217.0, evaporation = 2.257e6;  // [J/(kg K)], [J/kg]
  const double share = specific_heat * subcooling / evaporation;
  return 1.0 + 2.7 * std::sqrt(density_ratio) * share * share;
}

}  // namespace

Boiling boiling_of(const Water& water, double water_flow, double time) {
  const Boiling stated{water.critical_heat_flux, water.film_boiling_above,
                       water.film_boiling_coefficient};
  if (!water.boiling_follows_flow) return stated;
  const double subcooling = std::max(0.0, boiling_point - water.temperature(time));
  const double share = subcooling / stated_subcooling, flow = water_flow / start_flow;
  return {stated.critical_heat_flux * std::cbrt(water_flow / full_flow) *
              subcooling_gain(subcooling) / subcooling_gain(stated_subcooling),
          boiling_point + (stated.leidenfrost - boiling_point) * flow * share,
          stated.film_coefficient * std::sqrt(flow) * share};
}

double film_share(const Water& water, const Boiling& boiling, double surface_temperature,
                  bool wetted) {
  if (!water.film_boiling && !water.boiling_follows_flow) return 0.0;
  const bool holds = wetted && water.boiling_follows_flow;
  const double above = surface_temperature - boiling.leidenfrost - (holds ? film_hysteresis : 0.0);
  return std::clamp(above / film_boiling_blend + 0.5, 0.0, 1.0);
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
