#include "server/levers/sound_levers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>

#include "proto/case_file/schedule.hpp"

namespace dccast::levers {

namespace {

constexpr const char* temperature_lever = "casting_temperature_c";
constexpr const char* water_temperature_lever = "water_temperature_c";

/// Above plan and liquidus; the superheat of castings is 20 to 60 K [K].
constexpr double most_superheat = 150.0;
/// Farther from the plan an explanation would be a guess [K].
constexpr double near_plan_k = 40.0;
/// Largest planned value times this is beyond any pump and drive.
constexpr double most_of_plan = 4.0;
/// As near to the plan a rate has to come for an explanation to be one.
constexpr double near_plan = 1.5;

struct WrongTemperature {
  std::function<double(double)> truth;  ///< of what is shown [°C]
  const char* text;
};

double kelvin_to_c(double kelvin) {
  return kelvin - 273.15;
}

double fahrenheit_to_c(double fahrenheit) {
  return (fahrenheit - 32.0) / 1.8;
}

/// A sensor that shows another unit, or the right one whose column names another.
const std::array<WrongTemperature, 7>& wrong_temperatures() {
  static const std::array<WrongTemperature, 7> all{
      {{kelvin_to_c, "the sensor shows K"},
       {fahrenheit_to_c, "the sensor shows degF"},
       {[](double shown) { return shown + 273.15; }, "what is read as K is in degC"},
       {[](double shown) { return 1.8 * shown + 32.0; }, "what is read as degF is in degC"},
       {[](double shown) { return 0.1 * shown; }, "it is ten times too large"},
       {[](double shown) { return 10.0 * shown; }, "it is a tenth"},
       {[](double shown) { return -shown; }, "its sign is turned"}}};
  return all;
}

bool is_temperature(const std::string& lever) {
  return lever.ends_with("temperature_c");
}

const char* unit_of(const std::string& lever) {
  if (is_temperature(lever)) return "degC";
  return lever == "casting_speed_m_per_s" ? "m/s" : "m2/s";
}

}  // namespace

const std::vector<WrongScale>& wrong_scales() {
  static const std::vector<WrongScale> all{
      {-1.0, "its sign is turned"},
      {10.0, "it is ten times too large"},
      {0.1, "it is a tenth"},
      {-10.0, "it is ten times too large, its sign turned"},
      {-0.1, "it is a tenth, its sign turned"},
      {60.0, "what is read per second is per minute", true},
      {1.0 / 60.0, "what is read per minute is per second", true},
      {1000.0, "what is read as m is in mm"},
      {1e-3, "what is read as mm is in m"},
      {25.4, "what is read as inches is in mm"},
      {1.0 / 25.4, "what is read as mm is in inches"}};
  return all;
}

SoundLevers::SoundLevers(const v1::Case& plan) {
  const case_file::CastingSchedule schedule(plan);
  const std::vector<case_file::Instant> instants = schedule.instants();
  const auto add = [&](const char* lever, const case_file::PlannedQuantity& planned) {
    if (planned.table.value().empty()) return;
    Range range;
    range.least_planned = range.most_planned = planned.at({});
    for (const case_file::Instant& instant : instants) {
      range.least_planned = std::min(range.least_planned, planned.at(instant));
      range.most_planned = std::max(range.most_planned, planned.at(instant));
    }
    range.highest = most_of_plan * range.most_planned;
    range.reason = fmt::format("{:g} times the most that is planned", most_of_plan);
    if (range.most_planned > 0.0) ranges_.emplace(lever, range);
  };

  add("casting_speed_m_per_s", schedule.casting_speed());
  add("water_flow_m2_per_s", schedule.water_flow(case_file::Face::wide));
  if (schedule.has_narrow_water())
    add("narrow_water_flow_m2_per_s", schedule.water_flow(case_file::Face::narrow));
  add("second_water_flow_m2_per_s", schedule.second_water_flow());
  add(temperature_lever, schedule.casting_temperature());
  add(water_temperature_lever, schedule.water_temperature(case_file::Face::wide));

  if (const auto water = ranges_.find(water_temperature_lever); water != ranges_.end()) {
    water->second.highest = 100.0;
    water->second.reason = "from freezing to boiling";
  }
  if (const auto metal = ranges_.find(temperature_lever); metal != ranges_.end()) {
    const v1::Alloy& alloy = plan.alloy();
    Range& range = metal->second;
    range.lowest = alloy.solidus_c();
    range.highest = std::max(range.most_planned, alloy.liquidus_c()) + most_superheat;
    range.reason =
        fmt::format("from the solidus to {:g} K above plan and liquidus", most_superheat);
  }
}

std::string SoundLevers::limit_passed(const std::string& lever, double value) const {
  const auto found = ranges_.find(lever);
  if (found == ranges_.end()) return {};
  const Range& range = found->second;
  if (value >= range.lowest && value <= range.highest) return {};
  return fmt::format("{:.4g} to {:.4g} {}, {}", range.lowest, range.highest, unit_of(lever),
                     range.reason);
}

std::string SoundLevers::explanation(const std::string& lever, double value) const {
  const auto found = ranges_.find(lever);
  if (found == ranges_.end()) return {};
  const Range& range = found->second;
  const auto text = [&](const char* mistake, double truth) {
    return fmt::format("; if {}, it is {:.4g} {}", mistake, truth, unit_of(lever));
  };

  if (is_temperature(lever)) {
    for (const WrongTemperature& wrong : wrong_temperatures()) {
      const double truth = wrong.truth(value);
      if (truth >= std::max(range.least_planned - near_plan_k, range.lowest) &&
          truth <= range.most_planned + near_plan_k)
        return text(wrong.text, truth);
    }
    return {};
  }

  for (const WrongScale& wrong : wrong_scales()) {
    const double truth = value / wrong.factor;
    if (truth > 0.0 && truth >= range.least_planned / near_plan &&
        truth <= range.most_planned * near_plan)
      return text(wrong.text, truth);
  }
  return {};
}

}  // namespace dccast::levers
