#include "client/html/recipe_page.hpp"

#include <algorithm>

#include "client/html/html_parts.hpp"
#include "client/html/study_page.hpp"
#include "client/html/svg_chart.hpp"
#include "client/model/effects.hpp"
#include "client/text/recipe_text.hpp"
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
  const auto x = [&](double metres) { return fixed(axis.at(metres), 1); };
  std::string svg = "<text class='label' text-anchor='end' x='80' y='" + fixed(y + 4.0, 1) + "'>" +
                    name + "</text><rect x='" + x(candidate.low_m()) + "' y='" + fixed(y - 4.0, 1) +
                    "' width='" +
                    fixed(axis.at(candidate.high_m()) - axis.at(candidate.low_m()), 1) +
                    "' height='8' style='fill:var(--line-0)'><title>5 to 95 % of castings: " +
                    fixed(1e3 * candidate.low_m(), 1) + " to " +
                    fixed(1e3 * candidate.high_m(), 1) + " mm</title></rect>";
  if (candidate.has_full_curl_m())
    svg += "<circle cx='" + x(candidate.full_curl_m()) + "' cy='" + fixed(y, 1) +
           "' r='6' style='fill:var(--line-1)'><title>at full quality: " +
           fixed(1e3 * candidate.full_curl_m(), 1) + " mm</title></circle>";
  return svg;
}

/// The curls of every recipe over those that are accepted.
std::string curls(const v1::StudyResult& result) {
  const v1::RecipePlan& plan = result.study().recipe();
  const v1::RecipeFound& found = result.recipe();
  const Axis axis = axis_of(result);
  constexpr double row = 26.0;
  const double height = row * (found.front_size() + (found.has_itself() ? 1 : 0)) + 30.0;
  std::string svg = "<svg viewBox='0 0 910 " + fixed(height, 0) +
                    "' role='img' aria-label='curl of each recipe'><rect class='wanted' x='" +
                    fixed(axis.at(plan.least_curl_m()), 1) + "' y='4' width='" +
                    fixed(axis.at(plan.greatest_curl_m()) - axis.at(plan.least_curl_m()), 1) +
                    "' height='" + fixed(height - 26.0, 1) + "'/>";
  double y = 18.0;
  for (int i = 0; i < found.front_size(); ++i, y += row)
    svg += line_of("recipe " + std::to_string(i + 1), found.front(i), axis, y);
  if (found.has_itself()) svg += line_of("case", found.itself(), axis, y);
  for (const double tick : round_ticks(axis.low, axis.high, 6))
    svg += "<text class='tick' text-anchor='middle' x='" + fixed(axis.at(1e-3 * tick), 1) +
           "' y='" + fixed(height - 6.0, 1) + "'>" + fixed(tick, 0) + " mm</text>";
  return svg + "</svg>";
}

}  // namespace

std::string recipe_page(const v1::StudyResult& result) {
  std::string answer;
  for (const std::string& sentence : recipe_sentences(result))
    answer += html_escaped(sentence) + " ";
  std::string body = element("p class='answer'", answer);
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
