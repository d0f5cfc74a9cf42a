#include "proto/case_file/study_keys.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <regex>

#include <fmt/core.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::case_file {
namespace {

bool has_points_in_time(const v1::Curve& curve) {
  return curve.value_size() > 1 && curve.abscissa() == v1::TIME;
}

const std::array all_levers{
    Lever{"schedule.casting_speed.scale", "0.9..1.1"},
    Lever{
        "schedule.casting_speed.shift", "-10 s..10 s",
        [](const v1::Case& c) { return has_points_in_time(c.schedule().casting_speed_m_per_s()); }},
    Lever{"schedule.water_flow.scale", "0.9..1.1",
          [](const v1::Case& c) { return c.cooling().water().enabled(); }},
    Lever{"schedule.water_flow.shift", "-10 s..10 s",
          [](const v1::Case& c) { return has_points_in_time(c.schedule().water_flow_m2_per_s()); }},
    Lever{"schedule.second_water_flow.scale", "0.9..1.1",
          [](const v1::Case& c) { return c.cooling().has_second_water(); }},
    Lever{"schedule.casting_temperature.offset", "-10 K..10 K"},
    Lever{"cooling.water.temperature.offset", "-5 K..5 K",
          [](const v1::Case& c) { return c.cooling().water().enabled(); }},
    Lever{"cooling.bottom_block.temperature.offset", "-20 K..20 K"},
    Lever{"schedule.filling.scale", "0.9..1.1",
          [](const v1::Case& c) { return c.schedule().filling_s() > 0.0; }},
    Lever{"schedule.hold.scale", "0.9..1.1",
          [](const v1::Case& c) { return c.schedule().hold_s() > 0.0; }},
    Lever{"section.block_above_water.offset", "-5 mm..5 mm",
          [](const v1::Case& c) { return c.section().has_block_above_water_m(); }},
};

}  // namespace

std::span<const Lever> levers() {
  return all_levers;
}

bool is_lever(const std::string& axis_key) {
  return std::ranges::any_of(levers(), [&](const Lever& lever) { return axis_key == lever.key; });
}

std::string datum_of(const std::string& axis_key) {
  for (const char* suffix : {".scale", ".offset", ".shift"})
    if (axis_key.ends_with(suffix)) return axis_key.substr(0, axis_key.rfind('.'));
  return axis_key;
}

std::string range_of(const v1::SweepPlan::Axis& axis) {
  constexpr double margin = 1e-9;
  if (axis.values_size() != 2) return {};
  const std::string& low = axis.values(0);
  const std::string& high = axis.values(1);
  const double from = leading_number(low);
  const double to = leading_number(high);

  if (axis.key().ends_with(".scale")) {
    if (std::abs(from + to - 2.0) > margin) return fmt::format("{}..{} times", low, high);
    return fmt::format("± {} %", number_text(std::round(1e6 * (to - 1.0)) / 1e4));
  }
  const bool by_difference = axis.key().ends_with(".offset") || axis.key().ends_with(".shift");
  if (by_difference && std::abs(from + to) < margin) return "± " + high;

  // A unit common to both ends is written once.
  const auto unit = high.find(' ');
  if (unit != std::string::npos && low.ends_with(high.substr(unit)))
    return fmt::format("{}..{}", low.substr(0, low.size() - (high.size() - unit)), high);
  return fmt::format("{}..{}", low, high);
}

std::string unit_of_change(const std::string& axis_key) {
  if (axis_key.ends_with(".scale")) return "1";
  if (axis_key.ends_with(".shift")) return "s";

  // The reference has lists without their numbers: "cooling.zone[].from".
  static const std::regex number(R"(\[\d+\])");
  const std::string path = std::regex_replace(datum_of(axis_key), number, "[]");
  const bool is_difference = axis_key.ends_with(".offset");
  for (const KeyReference& known : reference(*v1::Case::descriptor()))
    if (known.path == path || known.path + "[]" == path)
      return is_difference && known.unit == "degC" ? "K" : known.unit;
  return {};
}

double leading_number(const std::string& text) {
  return std::strtod(text.c_str(), nullptr);
}

std::string rounded(const std::string& text) {
  constexpr double digits = 4.0;
  const double number = leading_number(text);
  if (!(std::abs(number) > 0.0) || !std::isfinite(number)) return text;

  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(number))) + 1.0 - digits);
  const auto blank = std::min(text.find(' '), text.size());
  // Divided by a power of ten if it is below 1, so that 0.93 is not written as 0.93000000000000005.
  const double steps = std::round(number / unit);
  const double value = unit < 1.0 ? steps / std::round(1.0 / unit) : steps * std::round(unit);
  return number_text(value) + text.substr(blank);
}

int monitor_of(const v1::StudyResult& result, const std::string& asked) {
  const std::string& name = asked.empty() ? result.judged_monitor() : asked;
  if (!name.empty()) {
    const auto found = std::ranges::find(result.monitors(), name);
    return found == result.monitors().end() ? -1
                                            : static_cast<int>(found - result.monitors().begin());
  }

  int largest = result.monitors().empty() ? -1 : 0;
  double most = -1.0;
  for (const v1::StudyRun& run : result.runs())
    for (int monitor = 0; monitor < run.end_curl_m_size(); ++monitor)
      if (std::abs(run.end_curl_m(monitor)) > most) {
        most = std::abs(run.end_curl_m(monitor));
        largest = monitor;
      }
  return largest;
}

}  // namespace dccast::case_file
