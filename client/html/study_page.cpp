#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/core.h>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/text/study_text.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client::render {
namespace {

constexpr std::size_t most_lines = 6;  // that the style has colours for

/// A value of a key as it is drawn.
struct Scale {
  std::string key;
  std::string unit;     ///< as the runs have it; empty where they differ
  double factor = 1.0;  ///< from SI
  double offset = 0.0;

  double drawn(double number) const { return factor * number + offset; }
  std::string label() const { return unit.empty() ? key : key + ", " + unit; }
};

/// The unit in "40 mm/min"; empty when there is none.
std::string unit_in(const std::string& value) {
  const auto end = value.find_first_not_of("+-.0123456789eE");
  if (end == std::string::npos) return {};
  const auto begin = value.find_first_not_of(' ', end);
  return begin == std::string::npos ? std::string() : value.substr(begin);
}

/// A key whose values are all numbers in one unit, or in SI.
Scale scale_of(const v1::StudyResult& result, int axis) {
  Scale scale{result.study().sweep().axes(axis).key(), {}, 1.0, 0.0};
  std::vector<std::pair<double, double>> seen;  // SI, as written
  for (const v1::StudyRun& run : result.runs()) {
    if (seen.empty()) scale.unit = unit_in(run.values(axis));
    if (unit_in(run.values(axis)) != scale.unit) return {scale.key, "SI", 1.0, 0.0};
    const std::pair pair(run.numbers(axis), leading_number(run.values(axis)));
    if (seen.size() < 2 && (seen.empty() || seen[0].first != pair.first)) seen.push_back(pair);
  }
  if (seen.size() < 2) return scale;
  scale.factor = (seen[1].second - seen[0].second) / (seen[1].first - seen[0].first);
  scale.offset = seen[0].second - scale.factor * seen[0].first;
  return scale;
}

bool is_numeric(const v1::StudyResult& result, int axis) {
  return std::ranges::all_of(result.runs(), [axis](const v1::StudyRun& run) {
    return axis < run.numbers_size() && std::isfinite(run.numbers(axis));
  });
}

/// The values of all keys but one, which part the runs into lines.
std::string others_of(const v1::StudyRun& run, int axis) {
  std::vector<std::string> values(run.values().begin(), run.values().end());
  if (axis < run.values_size()) values.erase(values.begin() + axis);
  return joined(values);
}

bool has_curl(const v1::StudyRun& run, int monitor) {
  return monitor < run.end_curl_m_size() && std::isfinite(run.end_curl_m(monitor));
}

/// A line for each combination of the other keys, of one monitor.
std::vector<ChartLine> lines_of(const v1::StudyResult& result, int axis, int monitor,
                                const Scale& scale) {
  std::map<std::string, std::vector<std::pair<double, double>>> points;
  for (const v1::StudyRun& run : result.runs())
    if (has_curl(run, monitor))
      points[others_of(run, axis)].emplace_back(scale.drawn(run.numbers(axis)),
                                                1e3 * run.end_curl_m(monitor));
  std::vector<ChartLine> lines;
  for (auto& [name, line_points] : points) {
    std::sort(line_points.begin(), line_points.end());
    ChartLine& line = lines.emplace_back();
    line.name = name.empty() ? result.monitors(monitor) : name;
    for (const auto& [x, y] : line_points) {
      line.x.push_back(x);
      line.y.push_back(y);
    }
  }
  return lines;
}

/// Colour of a share 0 to 1: from blue over white to red.
std::string colour(double share) {
  const double away = 2.0 * share - 1.0;
  const int faint = static_cast<int>(235.0 * (1.0 - std::abs(away)));
  return away < 0.0 ? fmt::format("rgb({0},{0},200)", faint)
                    : fmt::format("rgb(200,{0},{0})", faint);
}

/// What a range of dots covers.
struct Range {
  double low = 0.0, high = 0.0;

  double share(double value) const { return high > low ? (value - low) / (high - low) : 0.5; }
};

/// Dots on two axes, coloured by the curl of a monitor.
struct Scatter {
  struct Dot {
    double x, y, curl_mm;
    bool beyond;
  };
  std::string x_label, y_label;
  std::vector<Dot> dots;  ///< fewer than two are no picture

  Range range(double Dot::*part) const {
    const auto [low, high] = std::ranges::minmax(dots, {}, part);
    return {low.*part, high.*part};
  }
  std::string svg() const;
  std::string range_text() const {
    const Range curl = range(&Dot::curl_mm);
    return "blue " + fixed(curl.low, 2) + " mm, red " + fixed(curl.high, 2) + " mm";
  }
};

std::string Scatter::svg() const {
  const Range x_range = range(&Dot::x), y_range = range(&Dot::y), curl = range(&Dot::curl_mm);
  const auto left = [&](double x) { return 70.0 + 460.0 * x_range.share(x); };
  const auto top = [&](double y) { return 310.0 - 270.0 * y_range.share(y); };
  const auto number = [](double value) {
    return case_file::number_text(std::stod(fixed(value, 4)));
  };
  // A thousand dots must be distinguishable too.
  const double radius = std::clamp(50.0 / std::sqrt(double(dots.size())), 2.0, 7.0);
  std::string text =
      "<svg viewBox='0 0 560 360' role='img' aria-label='curl of the runs'>"
      "<rect x='62' y='32' width='476' height='286' fill='none' class='grid'/>";
  for (const double x : {x_range.low, x_range.high})
    text += svg_text("class='label' text-anchor='middle'", left(x), 334, number(x));
  for (const double y : {y_range.low, y_range.high})
    text += svg_text("class='label' text-anchor='end'", 58, top(y) + 4, number(y));
  for (const Dot& dot : dots)
    text += fmt::format(
        "<circle cx='{:.1f}' cy='{:.1f}' r='{:.1f}' stroke='{}' stroke-width='.7' fill='{}'>"
        "<title>{:.3f} mm</title></circle>",
        left(dot.x), top(dot.y), radius, dot.beyond ? "var(--bad)" : "var(--soft)",
        colour(curl.share(dot.curl_mm)), dot.curl_mm);
  return text + svg_text("class='label' text-anchor='middle'", 300, 352, x_label) +
         svg_text("class='label' text-anchor='start'", 6, 14, y_label) + "</svg>";
}

/// The runs against one key, whatever the others are.
/// @param other  key of the vertical axis; empty: the curl
Scatter scatter_of(const v1::StudyResult& result, int axis, std::optional<int> other, int monitor) {
  const Scale x = scale_of(result, axis);
  const Scale y =
      other ? scale_of(result, *other) : Scale{"curl of " + result.monitors(monitor), "mm"};
  Scatter scatter{x.label(), y.label(), {}};
  for (const v1::StudyRun& run : result.runs()) {
    if (!has_curl(run, monitor)) continue;
    const double curl_mm = 1e3 * run.end_curl_m(monitor);
    scatter.dots.push_back({x.drawn(run.numbers(axis)),
                            other ? y.drawn(run.numbers(*other)) : curl_mm, curl_mm,
                            run.beyond_validity()});
  }
  return scatter;
}

std::string chart_against(const v1::StudyResult& result, int axis, int monitor) {
  const Scale scale = scale_of(result, axis);
  Chart chart{"Curl at the end against " + scale.key, scale.label(), "curl, mm", {}};
  const bool one_key = result.study().sweep().axes_size() == 1;
  for (int m = 0; m < result.monitors_size(); ++m)
    if (one_key || m == monitor)
      for (ChartLine& line : lines_of(result, axis, m, scale))
        chart.lines.push_back(std::move(line));
  const bool has_points =
      std::ranges::any_of(chart.lines, [](const ChartLine& line) { return line.x.size() > 1; });
  if (!has_points || chart.lines.size() > most_lines) {
    const Scatter scatter = scatter_of(result, axis, std::nullopt, monitor);
    if (scatter.dots.size() < 2) return {};
    return named_picture(scatter.svg(), "Curl of " + result.monitors(monitor) +
                                            " at the end against " + scale.key +
                                            ", a dot for each run");
  }
  return named_picture(
      svg_chart(chart),
      (one_key ? "Curl at the end" : "Curl of " + result.monitors(monitor) + " at the end") +
          " against " + scale.key);
}

std::string charts(const v1::StudyResult& result) {
  std::vector<int> numeric;
  for (int axis = 0; axis < result.study().sweep().axes_size(); ++axis)
    if (is_numeric(result, axis)) numeric.push_back(axis);
  const int monitor = monitor_of(result, "");
  if (result.monitors().empty()) return {};
  std::string html;
  for (const int axis : numeric) html += chart_against(result, axis, monitor);
  for (std::size_t i = 0; i < numeric.size(); ++i)
    for (std::size_t k = i + 1; k < numeric.size(); ++k) {
      const Scatter scatter = scatter_of(result, numeric[i], numeric[k], monitor);
      if (scatter.dots.size() < 2) continue;
      html += named_picture(scatter.svg(), "Curl of " + result.monitors(monitor) +
                                               " at the end: " + scatter.range_text());
    }
  return "<div class='pair'>" + html + "</div>";
}

std::string table_card(const std::string& title, const std::string& table) {
  return table.empty() ? "" : card(title, element("pre", html_escaped(table)));
}

std::vector<double> in_mm(std::vector<double> metres) {
  for (double& value : metres) value *= 1e3;
  return metres;
}

using Along = std::vector<double> frames::SteadyFace::*;

/// One line a run, of as many of the last ones as there are colours for.
std::string chart_of(const MouldDesign& design, const std::string& title, Along along,
                     bool with_tolerance) {
  Chart chart{title, "distance from the middle of the wide face, mm", "half-thickness, mm", {}};
  std::size_t number = 0;
  for (const MouldRun& run : design.runs) {
    ++number;
    if (run.cast)
      chart.lines.push_back({"run " + std::to_string(number), in_mm(run.cast->face.x_m),
                             in_mm(run.cast->face.*along)});
  }
  if (chart.lines.size() > most_lines)
    chart.lines.erase(chart.lines.begin(), chart.lines.end() - most_lines);
  if (chart.lines.empty()) return {};
  const double tolerance = design.result.study().mould().tolerance_m();
  if (with_tolerance)
    chart.wanted = Chart::Wanted{1e3 * (design.wanted_m - tolerance),
                                 1e3 * (design.wanted_m + tolerance), "wanted"};
  return named_picture(svg_chart(chart), title);
}

}  // namespace

std::string study_page(const v1::Study& study, const std::string& kind, const std::string& note,
                       const std::string& body) {
  const std::string title = html_escaped(study.title());
  return whole_page(title,
                    element("p class='kicker'", kind + " " + html_escaped(study.id())) +
                        element("h1", title) + element("p class='note'", html_escaped(note)),
                    body);
}

std::string sweep_page(const v1::StudyResult& result) {
  const v1::Study& study = result.study();
  return study_page(study, "Study", plan_text(study) + "; " + progress_text(study),
                    charts(result) + table_card("Runs", sweep_table(result)));
}

std::string mould_page(const MouldDesign& design) {
  const v1::Study& study = design.result.study();
  return study_page(
      study, "Mould design", mould_sentence(design),
      "<div class='pair'>" +
          chart_of(design, "Half-opening of the mould", &frames::SteadyFace::mould_m, false) +
          chart_of(design, "Cold slab", &frames::SteadyFace::cold_m, true) + "</div>" +
          table_card("Opening", mould_opening_table(design)) +
          table_card("Predicted cold slab", mould_profile_table(design)) +
          table_card("Runs", mould_runs_table(design)));
}

}  // namespace dccast::client::render
