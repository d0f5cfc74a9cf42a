#include "server/levers/lever_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "proto/case_file/schema.hpp"

namespace dccast::levers {

namespace {

constexpr double longest_off_s = 5.0;  // without an alarm
constexpr double far_share = 0.2;      // of the plan
constexpr double zero_share = 1e-3;    // of the plan; below it a sensor shows its noise
/// A shell that thins, or a film that dries out, follows its lever within a minute.
constexpr double acts_for_s = 60.0;

struct WatchedLever {
  const char* name;
  const char* field;  ///< of v1::Reading
  double factor;      ///< from its unit to that of plants
  const char* unit;   ///< of plants
  const char* at_zero;
  /// [its unit] beside the plan that is far; 0: `far_share`. Plants permit themselves 10 K of the
  /// metal, 5 K of the water and 5 mm of the level [A].
  double far_by = 0.0;
};

constexpr double per_minute = 6e4;  // of m/s and m2/s in mm/min and l/min/m
constexpr std::array<WatchedLever, 7> watched{
    {{"casting speed", "casting_speed_m_per_s", per_minute, "mm/min", "the block stands"},
     {"water", "water_flow_m2_per_s", per_minute, "l/min/m", "the water is off"},
     {"narrow water", "narrow_water_flow_m2_per_s", per_minute, "l/min/m",
      "the water of the narrow face is off"},
     {"second water", "second_water_flow_m2_per_s", per_minute, "l/min/m",
      "the second water is off"},
     {"metal", "casting_temperature_c", 1.0, "degC", "", 20.0},
     {"water temperature", "water_temperature_c", 1.0, "degC", "", 10.0},
     {"metal level", "metal_level_m", 1e3, "mm", "", 0.01}}};

/// Whether it is a speed or a flow, which is judged by its share of the plan.
bool is_rate(std::size_t lever) {
  return watched[lever].far_by == 0.0;
}
bool is_speed(std::size_t lever) {
  return lever == 0;
}

std::optional<double> value_of(std::size_t lever, const v1::Reading& reading) {
  const auto* const field = v1::Reading::descriptor()->FindFieldByName(watched[lever].field);
  return case_file::number_of(reading, *field);
}

std::string shown(std::size_t lever, double value) {
  const WatchedLever& of = watched[lever];
  return fmt::format("{:.{}f} {}", of.factor * value, is_speed(lever) ? 1 : 0, of.unit);
}

/// Flows of pulsed water are those of a moment.
bool is_pulsed(std::size_t lever, const v1::Case& plan) {
  if (!is_rate(lever) || is_speed(lever)) return false;
  return plan.cooling().water().pulse_period_s() > 0.0 ||
         plan.cooling().narrow_water().pulse_period_s() > 0.0;
}

}  // namespace

LeverWatch::LeverWatch(v1::Case plan) : plan_(std::move(plan)), planned_(plan_), sound_(plan_) {}

std::optional<LeverWatch::Beside> LeverWatch::beside(std::size_t lever, const v1::Reading& reading,
                                                     const v1::Reading& planned) const {
  const auto measured = value_of(lever, reading), plan = value_of(lever, planned);
  const bool by_share = is_rate(lever);
  if (!measured || !plan || (by_share && *plan <= 0.0) || is_pulsed(lever, plan_))
    return std::nullopt;

  Beside now{.measured = *measured, .planned = *plan};
  now.is_zero = by_share && *measured <= zero_share * *plan;
  const double off = *measured - *plan;
  const double far = by_share ? far_share * *plan : watched[lever].far_by;
  if (std::abs(off) >= far) now.side = off > 0.0 ? 1 : -1;
  return now;
}

void LeverWatch::follow(const v1::Reading& reading) {
  if (reading.closes()) return;
  planned_.follow(reading);
  if (reading.time_s() < gathers_speed_s) return;

  const v1::Reading planned = planned_.levers();
  for (std::size_t lever = 0; lever < watched.size(); ++lever)
    if (const auto now = beside(lever, reading, planned)) follow(lever, reading.time_s(), *now);
}

void LeverWatch::follow(std::size_t lever, double time_s, const Beside& now) {
  Course& course = courses_[lever];
  if (now.side != course.side) {
    if (course.alarm) alarms_[*course.alarm].end_s = time_s;
    course = {.side = now.side, .since_s = time_s, .zeros = 0, .alarm = {}};
  }
  if (now.side == 0) return;

  course.zeros = now.is_zero ? course.zeros + 1 : 0;
  // A speed that follows from a length is zero between two steps of its counter.
  const bool stays_zero = course.zeros >= 2 && !is_speed(lever);
  const bool stays_off = time_s - course.since_s >= longest_off_s;
  if (course.alarm) {
    const bool falls_to_zero = !alarms_[*course.alarm].is_zero && course.zeros >= 2;
    if (!falls_to_zero) return;
    alarms_[*course.alarm].end_s = time_s;
  } else if (!stays_zero && !stays_off) {
    return;
  }
  raise(lever, time_s, now);
}

void LeverWatch::raise(std::size_t lever, double time_s, const Beside& now) {
  const WatchedLever& of = watched[lever];
  Alarm alarm{.lever = lever, .begin_s = courses_[lever].since_s, .end_s = {}};
  alarm.is_zero = now.is_zero;
  alarm.warning.set_time_s(time_s);
  alarm.warning.set_monitor(of.name);
  alarm.warning.set_text(fmt::format("{}{}, the plan has {}",
                                     now.is_zero ? std::string(of.at_zero) + ": " : "",
                                     shown(lever, now.measured), shown(lever, now.planned)));

  // "; if it is a tenth, it is 0.001 m/s": a wrong unit explains the value.
  const std::string explanation = sound_.explanation(of.field, now.measured);
  if (now.is_zero || explanation.empty())
    alarm.warning.add_causes("the plant itself, or its sensor");
  else
    alarm.warning.add_causes("the unit of its column" + explanation);
  alarm.remedy =
      fmt::format("bring the {} back to its plan, {}", of.name, shown(lever, now.planned));

  courses_[lever].alarm = alarms_.size();
  alarms_.push_back(std::move(alarm));
}

std::vector<v1::ForecastWarning> LeverWatch::under_way() const {
  std::vector<v1::ForecastWarning> warnings;
  for (const Alarm& alarm : alarms_)
    if (!alarm.end_s) warnings.push_back(alarm.warning);
  return warnings;
}

std::string LeverWatch::remedy_at(double time_s) const {
  std::vector<std::string> remedies;
  std::array<bool, count> seen{};
  for (auto alarm = alarms_.rbegin(); alarm != alarms_.rend(); ++alarm) {
    const bool acts =
        alarm->begin_s <= time_s && (!alarm->end_s || time_s <= *alarm->end_s + acts_for_s);
    if (acts && !std::exchange(seen[alarm->lever], true)) remedies.push_back(alarm->remedy);
  }
  if (remedies.empty()) return {};
  return fmt::format("First {}.", fmt::join(remedies, ", and "));
}

std::vector<PouredLever> poured_levers(const v1::Case& plan,
                                       const std::vector<v1::Reading>& readings) {
  struct Sums {
    int count = 0;
    double planned = 0.0, measured = 0.0, least = 0.0, most = 0.0;
  };
  std::array<Sums, watched.size()> sums{};
  PlannedLevers planned(plan);
  for (const v1::Reading& reading : readings) {
    if (reading.closes()) continue;
    planned.follow(reading);
    if (reading.time_s() < gathers_speed_s) continue;

    const v1::Reading levers = planned.levers();
    for (std::size_t lever = 0; lever < watched.size(); ++lever) {
      const auto measured = value_of(lever, reading);
      if (!measured) continue;
      Sums& sum = sums[lever];
      sum.least = sum.count == 0 ? *measured : std::min(sum.least, *measured);
      sum.most = sum.count == 0 ? *measured : std::max(sum.most, *measured);
      sum.measured += *measured;
      sum.planned += value_of(lever, levers).value_or(0.0);
      ++sum.count;
    }
  }

  std::vector<PouredLever> poured;
  for (std::size_t lever = 0; lever < watched.size(); ++lever) {
    const Sums& sum = sums[lever];
    if (sum.count == 0) continue;
    poured.push_back({watched[lever].name, shown(lever, sum.planned / sum.count),
                      shown(lever, sum.measured / sum.count),
                      fmt::format("{} to {}", shown(lever, sum.least), shown(lever, sum.most))});
  }
  return poured;
}

}  // namespace dccast::levers
