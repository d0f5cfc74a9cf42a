#include "proto/case_file/live_levers.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/recipe_numbers.hpp"
#include "proto/case_file/schedule.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::case_file {
namespace {

/// Width of a jump in a table that is interpolated linearly; no time step resolves it.
constexpr double jump_s = 1e-3;
constexpr double jump_m = 1e-6;

/// A lever that is a table of the schedule.
struct LiveLever {
  PlantLever lever;
  const char* unit;
  const v1::Curve& (v1::Schedule::*table)() const;
  bool is_factor;        ///< the step is a share of the value, otherwise it is added
  double comes_later_s;  ///< the table against time is shifted by this
};

/// Steps are [A]: ranges of plants are 45 to 55 and 58 to 70 mm/min, 75 to 120 and 150 to 220
/// l/min/m, and 5 to 15 K (docs/alloys.md).
std::vector<LiveLever> live_levers(const v1::Schedule& schedule) {
  const bool has_narrow_water = schedule.has_narrow_water_flow_m2_per_s();
  std::vector<LiveLever> levers{
      {.lever = {"schedule.casting_speed", "cast", "slower", "faster", 0.1},
       .unit = "m/s",
       .table = &v1::Schedule::casting_speed_m_per_s,
       .is_factor = true,
       .comes_later_s = schedule.casting_speed_shift_s()},
      {.lever = {"schedule.water_flow", "use", "less water", "more water", 0.2},
       .unit = "m2/s",
       .table = &v1::Schedule::water_flow_m2_per_s,
       .is_factor = true,
       .comes_later_s = schedule.water_flow_shift_s()}};

  if (has_narrow_water) {
    levers.back().lever.less = "less water on the wide faces";
    levers.back().lever.more = "more water on the wide faces";
    levers.push_back(
        {.lever = {"schedule.narrow_water_flow", "use", "less water on the narrow faces",
                   "more water on the narrow faces", 0.2},
         .unit = "m2/s",
         .table = &v1::Schedule::narrow_water_flow_m2_per_s,
         .is_factor = true,
         .comes_later_s = schedule.water_flow_shift_s()});
  }

  levers.push_back({.lever = {"schedule.casting_temperature", "pour", "colder", "hotter", 10.0},
                    .unit = "degC",
                    .table = &v1::Schedule::casting_temperature_c,
                    .is_factor = false,
                    .comes_later_s = 0.0});
  return levers;
}

/// The table of a lever that is moved from a place on, as in a case file: the old values up to
/// there, a jump, and the new ones.
/// @param from  [unit of the abscissa]
std::string moved_table(const LiveLever& lever, int towards, const v1::Curve& table, double from) {
  const bool by_length = is_by_length(table);
  const double jump = by_length ? jump_m : jump_s;
  const double step = towards * lever.lever.step;

  v1::Curve points;
  points.set_abscissa(by_length ? v1::CAST_LENGTH : v1::TIME);
  const auto add = [&](double at, double value) {
    points.add_at(at);
    points.add_value(value);
  };
  const auto moved = [&](double value) {
    return lever.is_factor ? value * (1.0 + step) : value + step;
  };

  for (int i = 0; i < table.at_size(); ++i)
    if (table.at(i) < from - jump) add(table.at(i), table.value(i));
  add(from - jump, curve_value(table, from - jump));
  add(from, moved(curve_value(table, from)));
  for (int i = 0; i < table.at_size(); ++i)
    if (table.at(i) > from) add(table.at(i), moved(table.value(i)));
  return curve_text(points, lever.unit);
}

}  // namespace

std::vector<LeverDraft> lever_drafts_from(const v1::Case& description, double from_s) {
  v1::Case complete = description;
  apply_defaults(complete);
  const v1::Schedule& schedule = complete.schedule();

  std::vector<LeverDraft> drafts;
  for (const LiveLever& each : live_levers(schedule)) {
    const PlantLever& lever = each.lever;
    const v1::Curve& table = (schedule.*each.table)();
    const double from = is_by_length(table) ? CastingSchedule(complete).cast_length_m(from_s)
                                            : from_s - each.comes_later_s;

    for (const int towards : {-1, 1}) {
      LeverDraft draft{{}, {change_of(lever.key, moved_table(each, towards, table, from))}};
      v1::Case changed = description;
      if (!apply_changes(changed, draft.changes).empty()) continue;

      apply_defaults(changed);
      if (const auto end = end_at_same_length(changed, complete)) draft.changes.push_back(*end);
      draft.step.set_key(lever.key);
      draft.step.set_steps(towards);
      draft.step.set_from_s(from_s);
      const std::string amount = each.is_factor ? fmt::format("{:.0f} %", 100.0 * lever.step)
                                                : fmt::format("{:.0f} K", lever.step);
      draft.step.set_words(
          fmt::format("{} {} {}", lever.verb, amount, towards < 0 ? lever.less : lever.more));
      drafts.push_back(std::move(draft));
    }
  }
  return drafts;
}

}  // namespace dccast::case_file
