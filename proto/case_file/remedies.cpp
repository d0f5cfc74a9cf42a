#include "proto/case_file/remedies.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/recipe_numbers.hpp"
#include "proto/case_file/schedule.hpp"
#include "proto/case_file/schema.hpp"
#include "proto/case_file/study_keys.hpp"

namespace dccast::case_file {
namespace {

using enum Direction;

// Steps are what a plant changes between two castings.
constexpr PlantLever hold_time{"schedule.hold.scale", "hold", "shorter", "longer", 0.25};
constexpr PlantLever speed{"schedule.casting_speed.scale", "cast", "slower", "faster", 0.1};
constexpr PlantLever water{"schedule.water_flow.scale", "use", "less water", "more water", 0.15};
constexpr PlantLever metal{"schedule.casting_temperature.offset", "pour", "colder", "hotter", 10.0};
constexpr PlantLever water_temperature{"cooling.water.temperature.offset", "use", "colder water",
                                       "warmer water", 5.0};
constexpr PlantLever second_water{"schedule.second_water_flow.scale", "use", "less second water",
                                  "more second water", 0.15};
constexpr PlantLever block{"section.block_above_water.offset", "place the block", "lower", "higher",
                           0.005};
// More of it is less heat flux; a step is a quarter of what the gas takes.
constexpr PlantLever gas{"cooling.water.critical_heat_flux_factor", "use gas:", "the critical flux",
                         "the critical flux", 0.25};

struct Row {
  const char* code;
  bool is_lower_limit;  ///< of codes that have a limit on both sides: the row of the lower one
  std::vector<Advice> advice;
};

/// Every code of docs/findings.md.
const std::vector<Row>& rows() {
  static const std::vector<Advice> thicker_shell{{&speed, less}, {&metal, less}, {&gas, less}};
  static const std::vector<Advice> thicker_bottom{
      {&hold_time, more}, {&speed, less}, {&metal, less}, {&water, less}};
  static const std::vector<Advice> flatter_butt{{&hold_time, more}, {&speed, less},
                                                {&water, less},     {&water_temperature, more},
                                                {&gas, more},       {&block, more}};
  static const std::vector<Advice> wetter_face{{&water, more},
                                               {&second_water, more},
                                               {&water_temperature, less},
                                               {&speed, less},
                                               {&metal, less}};

  static const std::vector<Row> table{
      {"no_superheat", false, {{&metal, more}}},
      {"coherency_in_liquid", false, {}},
      {"water_never_meets", false, {}},
      {"water_beyond_plants", false, {}},
      {"zone_never_meets", false, {}},
      {"table_never_reached", false, {}},
      {"energy_not_conserved", false, {}},
      {"weight_not_carried", false, {}},
      {"contact_violated", false, {}},
      {"level_overheats", false, {}},
      {"water_boils_away", false, wetter_face},
      {"water_thrown_off", false, wetter_face},
      {"water_beyond_capacity", false, {}},
      {"bleed_out_at_exit", false, thicker_shell},
      {"thin_shell", false, thicker_shell},
      {"freezes_at_meniscus", false, {{&metal, more}, {&speed, more}}},
      {"remelting_in_gap", false, thicker_shell},
      {"bottom_shell_fails", false, thicker_bottom},
      {"bottom_shell_open", false, thicker_bottom},
      {"bleed_out_at_bottom", false, thicker_bottom},
      {"sump_too_deep",
       false,
       {{&speed, less}, {&metal, less}, {&water, more}, {&second_water, more}}},
      {"shell_melted_through", false, thicker_bottom},
      {"steam_lifts_butt", false, {{&hold_time, more}, {&water, less}}},
      {"rotation_too_large", false, flatter_butt},
      {"slip_too_large", false, flatter_butt},
      {"centre_lifts", false, {}},
      {"lift_too_large", false, flatter_butt},
      {"may_hang_up", false, {}},
      {"hangs_up", false, {}},
      {"hot_tears", false, {{&speed, less}, {&metal, less}}},
      {"curl_outside_band",
       true,
       {{&hold_time, less}, {&speed, more}, {&water, more}, {&block, less}}},
      {"curl_outside_band", false, flatter_butt},
  };
  return table;
}

bool is_at_lower_limit(const v1::Finding& finding) {
  return finding.has_limit() && finding.value() < finding.limit();
}

bool is_factor(const PlantLever& lever) {
  return std::string_view(lever.key).ends_with(".scale");
}

bool is_temperature(const PlantLever& lever) {
  return &lever == &metal || &lever == &water_temperature;
}

/// A case without gas gets it until 100 mm of casting, as docs/quarter-slab.md has it; of a case
/// with gas its table changes. @return empty where there is nothing to take away, or no more to add
std::optional<v1::Curve> moved_gas(const v1::Case& complete, int steps) {
  constexpr double least = 0.1;  // [1] less was not compared with anything
  const double more = steps * gas.step;
  const auto has_gas = [](double factor) { return factor < 1.0; };

  const v1::Curve& before = complete.cooling().water().critical_heat_flux_factor();
  v1::Curve after = before;
  if (std::ranges::any_of(before.value(), has_gas)) {
    for (double& factor : *after.mutable_value())
      if (has_gas(factor)) factor = std::max(least, 1.0 - (1.0 - factor) * (1.0 + more));
  } else if (steps > 0) {
    after.Clear();
    after.set_abscissa(v1::CAST_LENGTH);
    for (const double at_m : {0.0, 0.1, 0.15}) after.add_at(at_m);
    for (const double factor : {1.0 - more, 1.0 - more, 1.0}) after.add_value(factor);
  }

  if (std::ranges::equal(before.value(), after.value())) return std::nullopt;
  return after;
}

/// "15 s", "10 %", "10 K", "5 mm": how far a lever is moved; of gas what it leaves, "0.5 of".
std::string amount_text(const PlantLever& lever, int steps, const v1::Case& complete) {
  const double distance = std::abs(steps) * lever.step;
  if (&lever == &gas)
    return fmt::format("{:.2g} of", *std::ranges::min_element(moved_gas(complete, steps)->value()));
  if (&lever == &hold_time) return fmt::format("{:.3g} s", distance * complete.schedule().hold_s());
  if (is_factor(lever)) return fmt::format("{:.0f} %", 100.0 * distance);
  if (is_temperature(lever)) return fmt::format("{:.0f} K", distance);
  return fmt::format("{:.0f} mm", 1e3 * distance);
}

std::string value_text(const PlantLever& lever, int steps, const v1::Case& complete) {
  if (&lever == &gas) return curve_text(*moved_gas(complete, steps), "1");
  if (is_factor(lever)) return number_text(1.0 + steps * lever.step);
  if (is_temperature(lever)) return number_text(steps * lever.step) + " K";
  return number_text(1e3 * steps * lever.step) + " mm";
}

/// Whether the case has what the lever moves. A case without gas has none to do without.
bool is_there(const PlantLever& lever, Direction direction, const v1::Case& complete) {
  if (&lever == &gas)
    return complete.cooling().water().enabled() &&
           moved_gas(complete, direction == more ? 1 : -1).has_value();
  const auto known =
      std::ranges::find(levers(), std::string_view(lever.key),
                        [](const Lever& other) { return std::string_view(other.key); });
  return known != levers().end() && (known->is_there == nullptr || known->is_there(complete));
}

v1::Case completed(v1::Case description) {
  apply_quality(description);
  apply_defaults(description);
  return description;
}

}  // namespace

std::vector<Advice> advice_against(const v1::Finding& finding) {
  const bool at_lower_limit = is_at_lower_limit(finding);
  for (const Row& row : rows())
    if (finding.code() == row.code && (!row.is_lower_limit || at_lower_limit)) return row.advice;
  return {};
}

bool has_advice_row(std::string_view code) {
  return std::ranges::any_of(rows(), [&](const Row& row) { return code == row.code; });
}

std::string remedy_text(const v1::Finding& finding) {
  // This finding is one of the metal temperature itself. Every other one has several causes, and
  // drafts of the casting at hand may refute any lever against it.
  if (finding.code() == "no_superheat") return "Pour hotter.";
  return {};
}

std::vector<Advice> advice_against(
    const google::protobuf::RepeatedPtrField<v1::Finding>& findings) {
  std::vector<Advice> collected;
  for (const v1::Finding& finding : findings)
    for (const Advice& advice : advice_against(finding))
      if (std::ranges::find(collected, advice.lever, &Advice::lever) == collected.end())
        collected.push_back(advice);
  return collected;
}

std::vector<LeverDraft> lever_drafts(const Advice& advice, const v1::Case& description) {
  const PlantLever& lever = *advice.lever;
  const v1::Case complete = completed(description);
  if (!is_there(lever, advice.direction, complete)) return {};

  std::vector<LeverDraft> drafts;
  const int towards = advice.direction == more ? 1 : -1;
  for (const int steps : {towards, 2 * towards, -towards}) {
    if (&lever == &gas && !moved_gas(complete, steps)) continue;
    LeverDraft draft{{}, {change_of(lever.key, value_text(lever, steps, complete))}};
    v1::Case changed = description;
    if (!apply_changes(changed, draft.changes).empty()) continue;
    changed = completed(changed);
    // The mould cannot be filled in less time than the metal is held.
    if (changed.schedule().hold_s() < changed.schedule().filling_s()) continue;

    if (const auto end = end_at_same_length(changed, complete)) draft.changes.push_back(*end);
    draft.step.set_key(lever.key);
    draft.step.set_steps(steps);
    draft.step.set_words(fmt::format("{} {} {}", lever.verb, amount_text(lever, steps, complete),
                                     steps < 0 ? lever.less : lever.more));
    drafts.push_back(std::move(draft));
  }
  return drafts;
}

}  // namespace dccast::case_file
