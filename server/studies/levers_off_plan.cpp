#include "server/studies/levers_off_plan.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "server/studies/planned_levers.hpp"

namespace dccast::studies {

namespace {

constexpr double minute_s = 60.0;
constexpr double farthest = 0.1;  // of the plan

/// Mean of a lever over the readings of the last minute that have it.
struct Mean {
  double measured = 0.0;
  double planned = 0.0;

  void add(double measured_now, double planned_now) {
    measured += measured_now;
    planned += planned_now;
  }
  /// Share by which the plan is left.
  double off() const { return planned > 0.0 ? measured / planned - 1.0 : 0.0; }
};

}  // namespace

std::vector<std::string> levers_off_plan(const v1::Schedule& plan,
                                         const std::vector<v1::Reading>& readings) {
  std::optional<double> last_s;
  for (const v1::Reading& reading : readings)
    if (!reading.closes()) last_s = reading.time_s();

  Mean speed, water, narrow_water;
  PlannedLevers plan_so_far(plan);
  for (const v1::Reading& reading : readings) {
    if (reading.closes() || reading.time_s() < 0.0) continue;
    plan_so_far.follow(reading);
    if (reading.time_s() <= *last_s - minute_s) continue;

    const v1::Reading planned = plan_so_far.levers();
    speed.add(reading.has_casting_speed_m_per_s() ? reading.casting_speed_m_per_s()
                                                  : planned.casting_speed_m_per_s(),
              planned.casting_speed_m_per_s());
    if (reading.has_water_flow_m2_per_s())
      water.add(reading.water_flow_m2_per_s(), planned.water_flow_m2_per_s());
    if (reading.has_narrow_water_flow_m2_per_s() && planned.has_narrow_water_flow_m2_per_s())
      narrow_water.add(reading.narrow_water_flow_m2_per_s(),
                       planned.narrow_water_flow_m2_per_s());
  }

  std::vector<std::string> notes;
  const auto add = [&](const char* lever, const Mean& mean) {
    if (std::abs(mean.off()) <= farthest) return;
    notes.push_back(fmt::format("{} was {:.0f} % {} planned over the last minute", lever,
                                100.0 * std::abs(mean.off()),
                                mean.off() > 0.0 ? "more than" : "less than"));
  };
  add("the casting speed", speed);
  add("the water", water);
  add("the water of the narrow face", narrow_water);
  return notes;
}

std::vector<PlanDeparture> plan_departures(const v1::Schedule& plan,
                                           const std::vector<v1::Reading>& readings) {
  constexpr double gathers_speed_s = 10.0;
  std::vector<PlanDeparture> departures;
  PlannedLevers plan_so_far(plan);
  double sum = 0.0;
  const auto add = [&](bool is_measured, double measured, double planned) {
    if (is_measured && planned > 0.0) sum += std::abs(measured / planned - 1.0);
  };

  for (const v1::Reading& reading : readings) {
    if (reading.closes()) continue;
    plan_so_far.follow(reading);
    if (reading.time_s() < gathers_speed_s) continue;

    const v1::Reading planned = plan_so_far.levers();
    add(reading.has_casting_speed_m_per_s(), reading.casting_speed_m_per_s(),
        planned.casting_speed_m_per_s());
    add(reading.has_water_flow_m2_per_s(), reading.water_flow_m2_per_s(),
        planned.water_flow_m2_per_s());
    add(reading.has_narrow_water_flow_m2_per_s(), reading.narrow_water_flow_m2_per_s(),
        planned.narrow_water_flow_m2_per_s());
    const auto count = static_cast<double>(departures.size() + 1);
    departures.push_back({reading.time_s(), sum / count});
  }
  return departures;
}

}  // namespace dccast::studies
