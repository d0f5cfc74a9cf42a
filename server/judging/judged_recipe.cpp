#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <map>

#include "server/judging/study_parts.hpp"

namespace dccast::judging {
namespace {

using v1::JudgementPart;
using Candidate = v1::RecipeFound::Candidate;

/// A number of a recipe, or the two levels of a ramp.
struct Number {
  const char* name;
  const char* to;  ///< name of the second level; null: none
  const char* heading;
  const char* unit;
  double resolution;
};

constexpr std::array numbers{
    Number{"speed_start", "speed_run", "speed", "m/s", 0.1 / 60e3},
    Number{"speed_ramp", nullptr, "ramp", "s", 1.0},
    Number{"filling", nullptr, "fill", "s", 0.1},
    Number{"hold", nullptr, "hold", "s", 0.1},
    Number{"water_start", "water_run", "water", "m2/s", 1.0 / 60e3},
    Number{"water_ramp", nullptr, "ramp", "s", 1.0},
};

bool is_in(const v1::RecipePlan& plan, const char* name) {
  return std::ranges::any_of(plan.numbers(),
                             [&](const auto& number) { return number.name() == name; });
}

std::map<std::string, double> numbers_of(const v1::RecipePlan& plan, const Candidate& candidate) {
  std::map<std::string, double> found;
  for (int i = 0; i < std::min(plan.numbers_size(), candidate.numbers_size()); ++i)
    found[plan.numbers(i).name()] = candidate.numbers(i);
  return found;
}

/// Half as wide as nine in ten: 1.645 standard errors.
std::optional<double> risk_error(const Candidate& candidate) {
  constexpr double nine_in_ten = 1.645;
  if (candidate.castings() == 0) return std::nullopt;
  return nine_in_ten * candidate.risk_error();
}

bool is_inside(const v1::RecipePlan& plan, double curl_m) {
  return curl_m >= plan.least_curl_m() && curl_m <= plan.greatest_curl_m();
}

/// The run at full quality, with a code where it does not confirm the recipe.
v1::Cell full_cell(const v1::RecipePlan& plan, const Candidate& candidate) {
  const bool in_danger = !candidate.full_dangers().empty();
  if (!candidate.has_full_curl_m()) return in_danger ? code_cell("fails") : v1::Cell();

  v1::Cell cell = number_cell(candidate.full_curl_m());
  if (in_danger)
    cell.set_code("danger");
  else if (!is_inside(plan, candidate.full_curl_m()))
    cell.set_code("out");
  return cell;
}

void add_candidate(const std::string& name, const v1::RecipePlan& plan, const Candidate& candidate,
                   v1::Table& table) {
  const auto values = numbers_of(plan, candidate);
  v1::Table::Row& row = *table.add_rows();
  *row.add_cells() = text_cell(name);
  for (const Number& number : numbers) {
    if (!is_in(plan, number.name)) continue;
    v1::Cell& cell = *row.add_cells();
    const auto value = values.find(number.name);
    if (value == values.end()) continue;
    cell = number_cell(value->second);
    if (number.to != nullptr && values.contains(number.to)) cell.set_until(values.at(number.to));
  }

  v1::Cell curl = number_cell(candidate.low_m());
  curl.set_until(candidate.high_m());
  for (v1::Cell& cell :
       std::vector<v1::Cell>{curl, number_cell(candidate.risk(), risk_error(candidate)),
                             candidate.castings() == 0 ? v1::Cell() : number_cell(candidate.lost()),
                             number_cell(candidate.casting_time_s()), full_cell(plan, candidate),
                             number_cell(candidate.castings()), text_cell(candidate.full_job())})
    *row.add_cells() = std::move(cell);
}

/// The front, then the recipe of the case itself.
void add_front(const v1::StudyResult& result, v1::Judgement& judgement) {
  const v1::RecipePlan& plan = result.study().recipe();
  const v1::RecipeFound& found = result.recipe();
  if (found.front().empty()) return;

  v1::Table& table =
      add_table(judgement, "recipes",
                fmt::format("recipes of least risk, curl of the {} at the cast length of the case",
                            found.monitor()));
  add_columns(table, {text_column("recipe", "no")});
  for (const Number& number : numbers)
    if (is_in(plan, number.name))
      add_columns(table,
                  {number_column(number.name, number.heading, number.unit, number.resolution)});
  constexpr double resolution_m = 1e-4;  // no recipe is known better
  add_columns(table, {number_column("curl", "5..95 %", "m", resolution_m)});
  table.mutable_columns()->rbegin()->set_has_bars(true);
  add_columns(table, {number_column("risk", "risk", "1", 0.01)});
  table.mutable_columns()->rbegin()->set_has_error(true);
  add_columns(table, {
                         number_column("lost", "lost", "", 1.0),
                         number_column("casting_time", "time", "s", 1.0),
                         number_column("full_curl", "full", "m", resolution_m),
                     });
  for (const char* key : {"castings", "full_job"}) add_columns(table, {text_column(key, "")});
  table.set_note(
      "5..95 %: curl of 9 of 10 castings; lost: castings outside the band or with a danger; full: "
      "the run at full quality, \"out\" of the band or with a \"danger\"");

  for (const Candidate& candidate : found.front())
    add_candidate(std::to_string(table.rows_size() + 1), plan, candidate, table);
  if (found.has_itself()) add_candidate("case", plan, found.itself(), table);
}

std::string band_text(const v1::RecipePlan& plan) {
  return fmt::format("{:.0f} to {:.0f} mm", 1e3 * plan.least_curl_m(),
                     1e3 * plan.greatest_curl_m());
}

std::string chosen_text(const v1::RecipePlan& plan, const v1::RecipeFound& found) {
  if (found.chosen() < 0 || found.chosen() >= found.front_size()) {
    const bool open = std::ranges::any_of(found.front(), [](const Candidate& candidate) {
      return candidate.full_state() != v1::SUCCEEDED && candidate.full_state() != v1::FAILED;
    });
    if (open) return "No recipe is confirmed yet: runs at full quality are to come.";
    return fmt::format(
        "No recipe is confirmed: the run of each at full quality ends outside {} or has a danger.",
        band_text(plan));
  }

  const Candidate& chosen = found.front(found.chosen());
  const auto error = risk_error(chosen);
  return fmt::format(
      "Recipe {}: {}{} % of castings end outside {} or with a danger ({} of {} that were looked "
      "at); its run at full quality ends with {} mm and no danger, after {:.0f} s.",
      found.chosen() + 1, percent(chosen.risk()), error ? " ± " + percent(*error) : "",
      band_text(plan), chosen.lost(), chosen.castings(), mm(chosen.full_curl_m()),
      chosen.casting_time_s());
}

std::string changes_text(const Candidate& candidate) {
  return joined(candidate.changes(), ", ", [](const v1::CaseChange& change) {
    return fmt::format("{} = {}", change.key(), change.value());
  });
}

void add_recipe_sentences(const v1::StudyResult& result, v1::Judgement& judgement) {
  const v1::RecipePlan& plan = result.study().recipe();
  const v1::RecipeFound& found = result.recipe();
  if (found.runs() == 0) {
    judgement.add_sentences(fmt::format("No answer yet: {}.", found.fault()));
    return;
  }

  judgement.add_sentences(chosen_text(plan, found));
  if (plan.has_experience()) {
    judgement.add_sentences(
        "These castings, those that were computed included, have data that what was cast leaves "
        "possible.");
    add_conditions(plan.experience(), judgement);
  }
  if (found.chosen() >= 0)
    judgement.add_sentences(fmt::format("It is {}.", changes_text(found.front(found.chosen()))));
  if (found.has_itself())
    judgement.add_sentences(fmt::format(
        "As the case is, {} % of castings end outside {} or with a danger, {} % with a danger.",
        percent(found.itself().risk()), band_text(plan), percent(found.itself().danger())));

  constexpr double no_recipe = 0.5;
  if (!found.front().empty() && found.front(0).risk() > no_recipe)
    judgement.add_sentences(
        "No recipe within these limits stays without a danger whatever the data are: what leaves "
        "them open has to be measured first (dccast uncertainty, dccast sensitivity).");
  judgement.add_sentences("A recipe is advice: the limits of your plant hold.");
  judgement.add_sentences(fmt::format(
      "The surfaces rest on {} drafts, {} with a danger; the curl is off by {} mm, the danger is "
      "misjudged in {} % of them. Curls of drafts count {:.2f} times, what full quality made of "
      "the case itself.",
      found.runs(), found.dangers(), mm(found.surface_error_m()), percent(found.misjudged()),
      found.full_over_draft()));
}

}  // namespace

void judge_recipe(const v1::StudyResult& result, v1::Judgement& judgement) {
  add_recipe_sentences(result, judgement);
  add_front(result, judgement);
}

}  // namespace dccast::judging
