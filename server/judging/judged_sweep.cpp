// A sweep: the curl at the end against the keys that were varied.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "proto/case_file/study_keys.hpp"
#include "server/judging/study_parts.hpp"

namespace dccast::judging {
namespace {

/// A curl at a place on one or two axes.
struct Point {
  double x;  ///< [SI]
  double y;  ///< [SI] value of the other axis, or the curl [m]
  double curl_m;
};
using Points = std::vector<Point>;

/// The unit in which an axis is drawn; a factor has none.
std::string axis_unit(const std::string& key) {
  const std::string unit = case_file::unit_of_change(key);
  return unit == "1" ? "" : unit;
}

bool is_numeric(const v1::StudyResult& result, int axis) {
  return std::ranges::all_of(result.runs(), [axis](const v1::StudyRun& run) {
    return axis < run.numbers_size() && std::isfinite(run.numbers(axis));
  });
}

bool has_curl(const v1::StudyRun& run, int monitor) {
  return monitor < run.end_curl_m_size() && std::isfinite(run.end_curl_m(monitor));
}

Axes axes_of(const v1::StudyResult& result, int axis, const std::string& y,
             const std::string& y_unit) {
  const std::string& key = result.study().sweep().axes(axis).key();
  return {key, axis_unit(key), y, y_unit};
}

v1::Chart::Line& add_points(v1::Chart& chart, const std::string& name, Points points) {
  std::ranges::sort(points, {}, &Point::x);
  v1::Chart::Line& line = *chart.add_lines();
  line.set_name(name);
  for (const Point& point : points) {
    line.add_x(point.x);
    line.add_y(point.y);
  }
  return line;
}

/// The values of all keys but one, by which the runs fall into lines.
std::string other_values(const v1::StudyRun& run, int axis) {
  std::vector<std::string> values(run.values().begin(), run.values().end());
  if (axis < run.values_size()) values.erase(values.begin() + axis);
  return joined(values, ", ");
}

/// The curl of a monitor by the values of the other keys.
std::map<std::string, Points> lines_against(const v1::StudyResult& result, int axis, int monitor) {
  std::map<std::string, Points> lines;
  for (const v1::StudyRun& run : result.runs()) {
    if (!has_curl(run, monitor)) continue;
    const double curl_m = run.end_curl_m(monitor);
    lines[other_values(run, axis)].push_back({run.numbers(axis), curl_m, curl_m});
  }
  return lines;
}

/// A line for each combination of the other keys; where there are too many, a dot for each run.
void add_curl_chart(const v1::StudyResult& result, int axis, int monitor,
                    v1::Judgement& judgement) {
  const auto lines = lines_against(result, axis, monitor);
  const bool has_lines =
      std::ranges::any_of(lines, [](const auto& line) { return line.second.size() > 1; });
  if (!has_lines && lines.size() < 2) return;

  const std::string& key = result.study().sweep().axes(axis).key();
  const std::string& name = result.monitors(monitor);
  v1::Chart& chart = add_chart(judgement, "curl_against_key",
                               fmt::format("curl of the {} at the end against {}", name, key),
                               axes_of(result, axis, "curl", "m"));
  if (has_lines && std::ssize(lines) <= most_lines) {
    for (const auto& [values, points] : lines)
      add_points(chart, values.empty() ? name : values, points);
    return;
  }

  Points all;
  for (const auto& [values, points] : lines) all.insert(all.end(), points.begin(), points.end());
  add_points(chart, "runs", std::move(all)).set_is_dotted(true);
}

/// Dots on two axes, in classes of the curl.
void add_pair_chart(const v1::StudyResult& result, int x, int y, int monitor,
                    v1::Judgement& judgement) {
  Points points;
  for (const v1::StudyRun& run : result.runs())
    if (has_curl(run, monitor))
      points.push_back({run.numbers(x), run.numbers(y), run.end_curl_m(monitor)});
  if (points.size() < 2) return;

  const std::string& key = result.study().sweep().axes(y).key();
  v1::Chart& chart = add_chart(
      judgement, "curl_against_two_keys",
      fmt::format("curl of the {} at the end, a dot for each run", result.monitors(monitor)),
      axes_of(result, x, key, axis_unit(key)));
  std::ranges::sort(points, {}, &Point::curl_m);
  const std::size_t classes = std::min<std::size_t>(most_lines - 1, points.size());
  for (std::size_t i = 0; i < classes; ++i) {
    const auto begin = points.begin() + static_cast<std::ptrdiff_t>(i * points.size() / classes);
    const auto end =
        points.begin() + static_cast<std::ptrdiff_t>((i + 1) * points.size() / classes);
    const std::string name =
        fmt::format("{} to {} mm", mm(begin->curl_m), mm(std::prev(end)->curl_m));
    add_points(chart, name, Points(begin, end)).set_is_dotted(true);
  }
}

}  // namespace

void judge_sweep(const v1::StudyResult& result, v1::Judgement& judgement) {
  const int monitor = monitor_of(result, "");
  std::vector<int> numeric;
  for (int axis = 0; axis < result.study().sweep().axes_size(); ++axis)
    if (is_numeric(result, axis)) numeric.push_back(axis);

  if (monitor >= 0) {
    for (const int axis : numeric) add_curl_chart(result, axis, monitor, judgement);
    for (std::size_t i = 0; i < numeric.size(); ++i)
      for (std::size_t k = i + 1; k < numeric.size(); ++k)
        add_pair_chart(result, numeric[i], numeric[k], monitor, judgement);
  }
  add_runs(result, judgement);
}

}  // namespace dccast::judging
