#include "client/text/data_study_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/core.h>

#include "client/model/answer.hpp"
#include "client/model/study.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"

namespace dccast::client::render {
namespace {

using Candidate = v1::RecipeFound::Candidate;

/// A column of a recipe: one number, or the two levels of a ramp.
struct Column {
  const char *heading, *number;
  const char* to;  ///< second level; null: none
  double factor;
};
constexpr Column columns[]{
    {">speed mm/min", "speed_start", "speed_run", mm_per_min},
    {">ramp s", "speed_ramp", nullptr, 1.0},
    {">fill s", "filling", nullptr, 1.0},
    {">hold s", "hold", nullptr, 1.0},
    {">water l/min/m", "water_start", "water_run", litres_per_min_per_m},
    {">ramp s", "water_ramp", nullptr, 1.0},
};

std::map<std::string, double> by_name(const v1::RecipePlan& plan, const Candidate& candidate) {
  std::map<std::string, double> numbers;
  for (int i = 0; i < std::min(plan.numbers_size(), candidate.numbers_size()); ++i)
    numbers[plan.numbers(i).name()] = candidate.numbers(i);
  return numbers;
}

bool has(const v1::RecipePlan& plan, const char* name) {
  return std::ranges::any_of(plan.numbers(),
                             [&](const auto& number) { return number.name() == name; });
}

std::string percent(double share) {
  return fixed(100.0 * share, 0);
}

/// Half as wide as nine in ten: 1.645 standard errors.
std::string risk_text(const Candidate& candidate) {
  constexpr double nine_in_ten = 1.645;
  if (candidate.castings() == 0) return percent(candidate.risk());
  return percent(candidate.risk()) + " ± " + percent(nine_in_ten * candidate.risk_error());
}

std::string full_text(const Candidate& candidate, const v1::RecipePlan& plan) {
  if (!candidate.has_full_curl_m()) return candidate.full_dangers().empty() ? "-" : "fails";
  const double curl = candidate.full_curl_m();
  const bool good = candidate.full_dangers().empty() && curl >= plan.least_curl_m() &&
                    curl <= plan.greatest_curl_m();
  return mm(curl) + (good ? "" : " !");
}

std::vector<std::string> row_of(const std::string& name, const v1::RecipePlan& plan,
                                const Candidate& candidate) {
  std::vector<std::string> row{name};
  const auto numbers = by_name(plan, candidate);
  for (const Column& column : columns) {
    if (!has(plan, column.number)) continue;
    const auto shown = [&](const char* number) {
      return plant_number(std::round(10.0 * column.factor * numbers.at(number)) / 10.0);
    };
    row.push_back(shown(column.number));
    if (column.to != nullptr && numbers.contains(column.to))
      row.back() += " to " + shown(column.to);
  }
  const std::string lost = fmt::format("{} of {}", candidate.lost(), candidate.castings());
  row.insert(row.end(), {mm(candidate.low_m()) + ".." + mm(candidate.high_m()),
                         risk_text(candidate), candidate.castings() == 0 ? "-" : lost,
                         fixed(candidate.casting_time_s(), 0), full_text(candidate, plan)});
  return row;
}

std::string band_text(const v1::RecipePlan& plan) {
  return mm(plan.least_curl_m(), 0) + " to " + mm(plan.greatest_curl_m(), 0) + " mm";
}

std::string chosen_text(const v1::RecipePlan& plan, const v1::RecipeFound& found) {
  if (found.chosen() < 0 || found.chosen() >= found.front_size()) {
    const bool open = std::ranges::any_of(found.front(), [](const Candidate& candidate) {
      return candidate.full_state() != v1::SUCCEEDED && candidate.full_state() != v1::FAILED;
    });
    return open ? "No recipe is confirmed yet: runs at full quality are to come."
                : "No recipe is confirmed: the run of each at full quality ends outside " +
                      band_text(plan) + " or has a danger.";
  }
  const Candidate& chosen = found.front(found.chosen());
  return fmt::format(
      "Recipe {}: {} % of castings end outside {} or with a danger ({} of {} that were looked at); "
      "its run at full quality ends with {} mm and no danger, after {} s.",
      found.chosen() + 1, risk_text(chosen), band_text(plan), chosen.lost(), chosen.castings(),
      mm(chosen.full_curl_m()), fixed(chosen.casting_time_s(), 0));
}

}  // namespace

std::vector<std::string> recipe_headings(const v1::RecipePlan& plan) {
  std::vector<std::string> headings{">recipe"};
  for (const Column& column : columns)
    if (has(plan, column.number)) headings.emplace_back(column.heading);
  for (const char* heading : {">5..95 % mm", ">risk %", ">lost", ">time s", ">full mm"})
    headings.emplace_back(heading);
  return headings;
}

Rows recipe_rows(const v1::StudyResult& result) {
  const v1::RecipePlan& plan = result.study().recipe();
  Rows rows;
  for (const Candidate& candidate : result.recipe().front())
    rows.push_back(row_of(std::to_string(rows.size() + 1), plan, candidate));
  if (result.recipe().has_itself()) rows.push_back(row_of("case", plan, result.recipe().itself()));
  return rows;
}

std::vector<std::string> recipe_sentences(const v1::StudyResult& result) {
  const v1::RecipePlan& plan = result.study().recipe();
  const v1::RecipeFound& found = result.recipe();
  if (found.runs() == 0) return {"No answer yet: " + found.fault() + "."};
  std::vector<std::string> sentences;
  if (found.has_itself())
    sentences.push_back(fmt::format(
        "As the case is, {} % of castings end outside {} or with a danger, {} % with a danger.",
        percent(found.itself().risk()), band_text(plan), percent(found.itself().danger())));
  sentences.push_back(chosen_text(plan, found));
  if (found.chosen() >= 0)
    sentences.push_back("It is " + changes_text(found.front(found.chosen()).changes()) + ".");
  constexpr double no_recipe = 0.5;
  if (!found.front().empty() && found.front(0).risk() > no_recipe)
    sentences.push_back(
        "No recipe within these limits is safe whatever the data are: what leaves them open has to "
        "be measured first (dccast uncertainty, dccast sensitivity).");
  sentences.push_back(fmt::format(
      "The surfaces rest on {} drafts, {} with a danger; the curl is off by {} mm, the danger is "
      "misjudged in {} % of them. Curls of drafts count {} times, what full quality made of the "
      "case itself.",
      found.runs(), found.dangers(), mm(found.surface_error_m()), percent(found.misjudged()),
      fixed(found.full_over_draft(), 2)));
  return sentences;
}

std::string recipe_text(const v1::StudyResult& result) {
  std::string text =
      fmt::format("study {}: {}\n{} runs: {}\n", result.study().id(), result.study().title(),
                  result.runs_size(), count_runs(result).text());
  if (!result.recipe().front().empty())
    text += "\nrecipes of least risk, curl of the " + result.recipe().monitor() +
            " at the cast length of the case\n" +
            Table(recipe_headings(result.study().recipe()), recipe_rows(result)).text();
  return text + "\n" + paragraphs(recipe_sentences(result));
}

}  // namespace dccast::client::render
