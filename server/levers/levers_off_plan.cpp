#include "server/levers/levers_off_plan.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "server/levers/planned_levers.hpp"

namespace dccast::levers {

namespace {

constexpr double minute_s = 60.0;
constexpr double farthest = 0.1;  // of the plan

enum Lever : std::size_t { speed, water, narrow_water, levers };

constexpr std::array<const char*, levers> names{"the casting speed", "the water",
                                                "the water of the narrow face"};

/// A lever beside its plan, of one reading or the sum of several.
struct BesidePlan {
  double measured = 0.0;
  double planned = 0.0;

  /// Share by which the plan is left.
  double off() const { return planned > 0.0 ? measured / planned - 1.0 : 0.0; }
};

/// Each lever of a reading beside its plan; zeros where it is not measured or not planned.
std::array<BesidePlan, levers> beside_plan(const v1::Reading& reading, const v1::Reading& planned) {
  std::array<BesidePlan, levers> beside{};
  if (reading.has_casting_speed_m_per_s())
    beside[speed] = {reading.casting_speed_m_per_s(), planned.casting_speed_m_per_s()};
  if (reading.has_water_flow_m2_per_s())
    beside[water] = {reading.water_flow_m2_per_s(), planned.water_flow_m2_per_s()};
  if (reading.has_narrow_water_flow_m2_per_s() && planned.has_narrow_water_flow_m2_per_s())
    beside[narrow_water] = {reading.narrow_water_flow_m2_per_s(),
                            planned.narrow_water_flow_m2_per_s()};
  return beside;
}

}  // namespace

std::vector<std::string> levers_off_plan(const v1::Case& plan,
                                         const std::vector<v1::Reading>& readings) {
  std::optional<double> last_s;
  for (const v1::Reading& reading : readings)
    if (!reading.closes()) last_s = reading.time_s();

  std::array<BesidePlan, levers> sums{};
  PlannedLevers plan_so_far(plan);
  for (const v1::Reading& reading : readings) {
    if (reading.closes() || reading.time_s() < 0.0) continue;
    plan_so_far.follow(reading);
    if (reading.time_s() <= *last_s - minute_s) continue;

    const auto now = beside_plan(reading, plan_so_far.levers());
    for (std::size_t lever = 0; lever < levers; ++lever) {
      sums[lever].measured += now[lever].measured;
      sums[lever].planned += now[lever].planned;
    }
  }

  std::vector<std::string> notes;
  for (std::size_t lever = 0; lever < levers; ++lever) {
    const double off = sums[lever].off();
    if (std::abs(off) <= farthest) continue;
    notes.push_back(fmt::format("{} was {:.0f} % {} planned over the last minute", names[lever],
                                100.0 * std::abs(off), off > 0.0 ? "more than" : "less than"));
  }
  return notes;
}

std::vector<PlanDeparture> plan_departures(const v1::Case& plan,
                                           const std::vector<v1::Reading>& readings) {
  std::vector<PlanDeparture> departures;
  PlannedLevers plan_so_far(plan);
  double sum = 0.0;
  for (const v1::Reading& reading : readings) {
    if (reading.closes()) continue;
    plan_so_far.follow(reading);
    if (reading.time_s() < gathers_speed_s) continue;

    for (const BesidePlan& lever : beside_plan(reading, plan_so_far.levers()))
      sum += std::abs(lever.off());
    const auto count = static_cast<double>(departures.size() + 1);
    departures.push_back({reading.time_s(), sum / count});
  }
  return departures;
}

}  // namespace dccast::levers
