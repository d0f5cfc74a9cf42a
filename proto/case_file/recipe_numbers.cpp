#include "proto/case_file/recipe_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "proto/case_file/override.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schedule.hpp"

namespace dccast::case_file {
namespace {

constexpr double default_ramp_s = 60.0;  // of a table with a single value

/// A table as a ramp: first and last value, begin and length [unit of the abscissa].
struct Ramp {
  double start = 0.0, run = 0.0, from = 0.0, length = default_ramp_s;
};

Ramp read_ramp(const v1::Curve& curve) {
  if (curve.value().empty()) return {};
  Ramp ramp{curve.value(0), curve.value(curve.value_size() - 1)};
  if (curve.value_size() > 1) {
    ramp.from = curve.at(0);
    ramp.length = curve.at(curve.at_size() - 1) - ramp.from;
  }
  return ramp;
}

double round_to_digits(double value, int digits) {
  if (value == 0.0) return 0.0;
  const double scale = std::pow(10.0, digits - 1 - std::floor(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

std::string format_rounded(double value, const std::string& unit) {
  // Rounded twice: to the scale, then to the digits from which a double can be read back.
  return quantity_text(std::stod(number_text(round_to_digits(value, 4))), unit);
}

/// A speed in mm/min, as plants write it; other values in SI units.
std::string value_text(double value, const std::string& unit) {
  if (unit == "m/s") return format_rounded(mm_per_min * value, "mm/min");
  if (unit == "m2/s") return format_rounded(litres_per_min_per_m * value, "l/min/m");
  return format_rounded(value, unit);
}

std::string table_text(const v1::Curve& curve, std::span<const double, 3> numbers,
                       const std::string& unit) {
  const double from = read_ramp(curve).from;
  const std::string at_unit = is_by_length(curve) ? "m" : "s";
  return fmt::format(R"([["{}", "{}"], ["{}", "{}"]])", quantity_text(from, at_unit),
                     value_text(numbers[0], unit), format_rounded(from + numbers[2], at_unit),
                     value_text(numbers[1], unit));
}

/// When the metal has risen to its level [s], without the round-off of the difference.
double time_of_full_mould(const v1::Case& complete) {
  return std::round(1e6 * CastingSchedule(complete).full_mould_s()) / 1e6;
}

bool differ(std::span<const double> a, std::span<const double> b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::abs(a[i] - b[i]) > 1e-9 * std::abs(b[i])) return true;
  return false;
}

}  // namespace

Recipe recipe_of(const v1::Case& complete) {
  const v1::Schedule& schedule = complete.schedule();
  const Ramp speed = read_ramp(schedule.casting_speed_m_per_s());
  const Ramp water = read_ramp(schedule.water_flow_m2_per_s());
  return {speed.start,       speed.run,   speed.length, schedule.filling_s(),
          schedule.hold_s(), water.start, water.run,    water.length};
}

std::vector<v1::CaseChange> recipe_changes(const v1::Case& complete, const Recipe& recipe) {
  const Recipe before = recipe_of(complete);
  const v1::Schedule& schedule = complete.schedule();
  std::vector<v1::CaseChange> changes;

  const auto change_ramp = [&](const char* key, const v1::Curve& curve, RecipeNumber first,
                               const char* unit) {
    const std::span<const double, 3> numbers(&recipe[first], 3);
    const bool other = differ(numbers, {&before[first], 3});
    if (other) changes.push_back(change_of(key, table_text(curve, numbers, unit)));
    return other;
  };
  const auto change_time = [&](const char* key, RecipeNumber number) {
    if (differ({&recipe[number], 1}, {&before[number], 1}))
      changes.push_back(change_of(key, format_rounded(recipe[number], "s")));
  };

  const bool other_speed =
      change_ramp("schedule.casting_speed", schedule.casting_speed_m_per_s(), speed_start, "m/s");
  change_time("schedule.hold", hold);
  change_time("schedule.filling", filling);
  change_ramp("schedule.water_flow", schedule.water_flow_m2_per_s(), water_start, "m2/s");
  v1::Case changed = complete;
  apply_changes(changed, changes);

  // Mechanics that begins with the full mould goes on doing so.
  const double full = time_of_full_mould(complete);
  const double full_after = time_of_full_mould(changed);
  if (full_after != full && std::abs(complete.mechanics().start_s() - full) < 1e-6)
    changes.push_back(change_of("mechanics.start", quantity_text(full_after, "s")));
  if (!other_speed) return changes;

  // With another speed the casting ends at another time.
  if (const auto end = end_at_same_length(changed, complete)) changes.push_back(*end);
  return changes;
}

std::optional<v1::CaseChange> end_at_same_length(const v1::Case& changed,
                                                 const v1::Case& complete) {
  constexpr double tolerance_s = 0.05;
  const double end_s = CastingSchedule(changed).time_of_cast_length_s(
      CastingSchedule(complete).cast_length_at_end_m());
  if (!std::isfinite(end_s) || std::abs(end_s - complete.time().end_s()) < tolerance_s)
    return std::nullopt;
  return change_of("time.end", quantity_text(std::round(10.0 * end_s) / 10.0, "s"));
}

}  // namespace dccast::case_file
