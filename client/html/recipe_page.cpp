#include <algorithm>

#include <fmt/core.h>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/text/data_study_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

using Candidate = v1::RecipeFound::Candidate;

/// From millimetres to the picture.
struct Axis {
  double low, high;
  double at(double metres) const { return 90.0 + 780.0 * (1e3 * metres - low) / (high - low); }
};

Axis axis_of(const v1::StudyResult& result) {
  const v1::RecipePlan& plan = result.study().recipe();
  double low = plan.least_curl_m(), high = plan.greatest_curl_m();
  const auto take = [&](const Candidate& candidate) {
    low = std::min(
        {low, candidate.low_m(), candidate.has_full_curl_m() ? candidate.full_curl_m() : low});
    high = std::max(
        {high, candidate.high_m(), candidate.has_full_curl_m() ? candidate.full_curl_m() : high});
  };
  for (const Candidate& candidate : result.recipe().front()) take(candidate);
  if (result.recipe().has_itself()) take(result.recipe().itself());
  const auto ticks = round_ticks(1e3 * low, 1e3 * high, 6);
  return {ticks.front(), ticks.back()};
}

std::string line_of(const std::string& name, const Candidate& candidate, const Axis& axis,
                    double y) {
  const double from = axis.at(candidate.low_m());
  std::string svg = fmt::format(
      "<text class='label' text-anchor='end' x='80' y='{:.1f}'>{}</text>"
      "<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='8' style='fill:var(--line-0)'>"
      "<title>5 to 95 % of castings: {:.1f} to {:.1f} mm</title></rect>",
      y + 4.0, name, from, y - 4.0, axis.at(candidate.high_m()) - from, 1e3 * candidate.low_m(),
      1e3 * candidate.high_m());
  if (candidate.has_full_curl_m())
    svg += fmt::format(
        "<circle cx='{:.1f}' cy='{:.1f}' r='6' style='fill:var(--line-1)'><title>at full quality: "
        "{:.1f} mm</title></circle>",
        axis.at(candidate.full_curl_m()), y, 1e3 * candidate.full_curl_m());
  return svg;
}

/// The curls of every recipe over those that are accepted.
std::string curls(const v1::StudyResult& result) {
  const v1::RecipePlan& plan = result.study().recipe();
  const v1::RecipeFound& found = result.recipe();
  const Axis axis = axis_of(result);
  constexpr double row = 26.0;
  const double height = row * (found.front_size() + (found.has_itself() ? 1 : 0)) + 30.0;
  const double from = axis.at(plan.least_curl_m());
  std::string svg = fmt::format(
      "<svg viewBox='0 0 910 {:.0f}' role='img' aria-label='curl of each recipe'>"
      "<rect class='wanted' x='{:.1f}' y='4' width='{:.1f}' height='{:.1f}'/>",
      height, from, axis.at(plan.greatest_curl_m()) - from, height - 26.0);
  double y = 18.0;
  for (int i = 0; i < found.front_size(); ++i, y += row)
    svg += line_of("recipe " + std::to_string(i + 1), found.front(i), axis, y);
  if (found.has_itself()) svg += line_of("case", found.itself(), axis, y);
  for (const double tick : round_ticks(axis.low, axis.high, 6))
    svg += svg_text("class='tick' text-anchor='middle'", axis.at(1e-3 * tick), height - 6.0,
                    fixed(tick, 0) + " mm");
  return svg + "</svg>";
}

}  // namespace

std::string recipe_page(const v1::StudyResult& result) {
  std::string body = answer(recipe_sentences(result));
  if (!result.recipe().front().empty()) {
    auto headings = recipe_headings(result.study().recipe());
    for (std::string& heading : headings)
      if (heading.starts_with('>')) heading.erase(0, 1);
    body += figure("Curl of the " + html_escaped(result.recipe().monitor()) +
                       " at the cast length of the case",
                   curls(result),
                   "Bars: 5 to 95 % of castings over the ranges of the data. Dots: runs at full "
                   "quality. Shaded: what is accepted.") +
            card("Recipes of least risk", table_of(headings, recipe_rows(result)) +
                                              "<p>How they were found: docs/recipe.md.</p>");
  }
  return study_page(result.study(), "Study",
                    std::to_string(result.runs_size()) + " runs: " + count_runs(result).text(),
                    body);
}

}  // namespace dccast::client::render
