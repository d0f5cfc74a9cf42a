#include "client/html/curl_part.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "client/html/html_parts.hpp"
#include "client/html/study_part.hpp"
#include "client/html/svg_chart.hpp"
#include "client/model/answer.hpp"
#include "client/text/findings.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

std::vector<double> millimetres(std::vector<double> metres) {
  for (double& value : metres) value *= 1e3;
  return metres;
}

/// Half the band around the curl of this run at the end: of its study, else that of its quality
/// [m].
std::optional<double> uncertainty(const v1::QueryResultResponse& result, const Study& study,
                                  const CurlHistory& history, const CurlHistory::Series& series) {
  const double curl = series.curl_m.back();
  if (const auto error = curl_error(study, series.name, history.time_s.back(), curl))
    return error->this_run_m;
  return discretisation_error(result.case_(), curl);
}

/// The plant's band [mm]; an edge that is not given is infinite.
std::optional<Chart::Wanted> plant_band(const v1::Case& input) {
  const v1::Plausibility& limits = input.plausibility();
  if (!limits.has_least_curl_m() && !limits.has_greatest_curl_m()) return std::nullopt;
  const double low = limits.has_least_curl_m() ? 1e3 * limits.least_curl_m() : -unbounded,
               high = limits.has_greatest_curl_m() ? 1e3 * limits.greatest_curl_m() : unbounded;
  std::string name = "the plant's band, ";
  if (std::isfinite(low)) name += plant_number(low) + (std::isfinite(high) ? " to " : " or more");
  if (std::isfinite(high)) name += (std::isfinite(low) ? "" : "up to ") + plant_number(high);
  return Chart::Wanted{low, high, name + " mm"};
}

/// "inside the plant's band, 35 to 45 mm", and whether the error permits this conclusion.
std::string against_band(const Chart::Wanted& band, double curl_mm, double error_mm) {
  const auto where = [&](double value) {
    return value < band.low ? "below " : value > band.high ? "above " : "inside ";
  };
  std::string text = std::string("It is ") + where(curl_mm) + html_escaped(band.name);
  if (std::string(where(curl_mm - error_mm)) != where(curl_mm + error_mm))
    text += ", but its limit is within the error: this run cannot decide";
  return text + ".";
}

std::string curl_chart(const CurlHistory& history, const v1::QueryResultResponse& result,
                       const Study& study, bool against_length) {
  Chart chart;
  chart.title = against_length ? "Butt curl against cast length" : "Butt curl against time";
  chart.x_label = against_length ? "cast length, mm" : "time, s";
  chart.y_label = "curl, mm";
  const auto x = against_length ? millimetres(history.cast_length_m) : history.time_s;
  const auto share = discretisation_error(result.case_(), 1.0);
  for (const auto& series : history.monitors) {
    ChartLine line{series.name, x, millimetres(series.curl_m),
                   curl_band(study, series.name, against_length)};
    if (study.monitors.empty() && share) line.band = band_around(line, *share);
    chart.lines.push_back(std::move(line));
  }
  if (const auto first = history.first_beyond()) {
    chart.beyond_from = x[*first];
    chart.beyond_name = beyond_validity;
  }
  chart.wanted = plant_band(result.case_());
  return svg_chart(chart);
}

std::string tile(const std::string& name, const std::string& value, const std::string& unit,
                 const std::string& note = {}) {
  return "<div class='tile'><span>" + html_escaped(name) + "</span><strong>" + value +
         "</strong> " + unit + (note.empty() ? "" : "<small>" + note + "</small>") + "</div>";
}

/// The curl at the end, with its error where a study or the quality gives it.
std::string curl_tile(const CurlHistory& history, const v1::QueryResultResponse& result,
                      const CurlHistory::Series& series, const Study& study) {
  const double curl = series.curl_m.back();
  const std::string mark = last_step_mark(history);
  const auto half_band = uncertainty(result, study, history, series);
  if (!half_band) return tile("curl, " + series.name, fixed(1e3 * curl, 2), "mm", mark);
  std::string note = "<em>± " + fixed(1e3 * *half_band, 2) + " mm</em>";
  if (const auto error = curl_error(study, series.name, history.time_s.back(), curl))
    note += std::string(error->extrapolated ? "limit " : "finest ") +
            fixed(1e3 * error->limit_m, 2) + " ± " + fixed(1e3 * error->uncertainty_m, 2);
  return tile("curl, " + series.name, fixed(1e3 * curl, 2), "mm",
              note + (mark.empty() ? "" : "<br>" + mark));
}

}  // namespace

std::string last_step_mark(const CurlHistory& history) {
  return !history.beyond.empty() && history.beyond.back() ? beyond_validity : "";
}

std::string curl_sentence(const CurlHistory& history, const v1::QueryResultResponse& result,
                          const Study& study) {
  const CurlHistory::Series* const largest = history.largest();
  if (largest == nullptr || !last_step_mark(history).empty()) return {};
  const double curl = 1e3 * largest->curl_m.back();
  const auto half_band = uncertainty(result, study, history, *largest);
  std::string text = "At " + fixed(history.time_s.back(), 0) + " s, after " +
                     fixed(1e3 * history.cast_length_m.back(), 0) + " mm of casting, " +
                     html_escaped(largest->name) + " has " + (curl < 0.0 ? "sunk " : "risen ") +
                     "<strong>" + fixed(std::abs(curl), 1) + " mm</strong>" +
                     " since the block started. ";
  text += half_band ? "Mesh and time steps leave ± " + fixed(1e3 * *half_band, 1) +
                          " mm of it uncertain; thermal data and alloy come on top. "
                    : "Its error from mesh and time steps has not been measured: <code>dccast "
                      "convergence</code> does that. ";
  if (const auto band = plant_band(result.case_()))
    text += against_band(*band, curl, half_band ? 1e3 * *half_band : 0.0);
  return "<p class='answer'>" + text + "</p>";
}

namespace {

/// The last step at which a curl is below this share of its end.
std::size_t last_below(const std::vector<double>& curl, double share) {
  std::size_t last = 0;
  for (std::size_t i = 0; i < curl.size(); ++i)
    if (curl[i] / curl.back() < share) last = i;
  return last;
}

/// Heat that left through faces and bottom in steps after `first` up to `last` [J, or J/m].
struct Heat {
  double faces = 0.0, bottom = 0.0;
};
Heat heat_between(const std::vector<v1::StepReport>& steps, std::size_t first, std::size_t last) {
  Heat heat;
  for (std::size_t i = first + 1; i <= last; ++i) {
    const v1::StepReport& step = steps[i];
    heat.faces += step.time_step_s() * (step.side_heat_w() + step.side_heat_w_per_m() +
                                        step.narrow_heat_w() + step.narrow_heat_w_per_m());
    heat.bottom += step.time_step_s() * (step.bottom_heat_w() + step.bottom_heat_w_per_m());
  }
  return heat;
}

/// "40 to 98 %", or "98 %".
std::string range_of_percent(double first, double last) {
  const std::string begin = fixed(100.0 * first, 0), end = fixed(100.0 * last, 0);
  return (begin == end ? "" : begin + " to ") + end + " %";
}

}  // namespace

std::string cause_sentence(const CurlHistory& history, const v1::QueryResultResponse& result) {
  constexpr double nothing = 1e-4;  // [m]
  const CurlHistory::Series* const largest = history.largest();
  if (largest == nullptr || !last_step_mark(history).empty() ||
      std::abs(largest->curl_m.back()) < nothing)
    return {};
  const std::size_t first = last_below(largest->curl_m, 0.25),
                    last = last_below(largest->curl_m, 0.75);
  std::string text = "Half of it came between " + fixed(history.time_s[first], 0) + " s and " +
                     fixed(history.time_s[last], 0) + " s, at " +
                     fixed(1e3 * history.cast_length_m[first], 0) + " to " +
                     fixed(1e3 * history.cast_length_m[last], 0) + " mm of casting. ";
  const Heat heat = heat_between(history.reports, first, last);
  if (const double all = heat.faces + heat.bottom; heat.faces > 0.0 && heat.bottom > 0.0)
    text += "Meanwhile " + fixed(100.0 * heat.faces / all, 0) +
            " % of the heat left through the faces, to mould and water, and " +
            fixed(100.0 * heat.bottom / all, 0) + " % through the bottom, to the block. ";
  const v1::Water& water = result.case_().cooling().water();
  if (water.enabled() && history.reports[last].wetted_share() > 0.0)
    text += "Water wetted " +
            range_of_percent(history.reports[first].wetted_share(),
                             history.reports[last].wetted_share()) +
            " of the side under the water line.";
  return "<p class='cause'>" + text + "</p>";
}

std::string headline(const CurlHistory& history, const v1::QueryResultResponse& result,
                     const Study& study) {
  if (history.time_s.empty()) return "<p>The job has no step yet.</p>";
  std::string tiles;
  for (const auto& series : history.monitors) tiles += curl_tile(history, result, series, study);
  const std::string mark = last_step_mark(history);
  const v1::StepReport& last = result.steps(result.steps_size() - 1);
  tiles += tile("cast length", fixed(1e3 * last.cast_length_m(), 1), "mm") +
           tile("time", fixed(last.time_s(), 1), "s");
  if (result.case_().section().kind() == v1::Section::QUARTER_SLAB)
    tiles += tile("stands on the block", fixed(1e4 * last.contact_area_m2(), 0), "cm²", mark);
  else
    tiles += tile("stands on the block", fixed(1e3 * last.contact_length_m(), 0), "mm", mark);
  tiles += tile("sump depth", fixed(1e3 * last.sump_depth_m(), 0), "mm", mark);
  return "<div class='tiles'>" + tiles + "</div>";
}

std::string curl_figure(const CurlHistory& history, const v1::QueryResultResponse& result,
                        const Study& study, bool against_length) {
  if (history.monitors.empty()) return {};
  const std::string of_the_band =
      !study.monitors.empty() ? " Dashed: the limit of finer meshes; shaded: its uncertainty."
      : discretisation_error(result.case_(), 1.0)
          ? " Shaded: what mesh and time steps leave uncertain."
          : "";
  const std::string of_the_plant = plant_band(result.case_()) ? " Green: the plant's band." : "";
  const std::string of_the_region = history.first_beyond() ? " Shaded red: beyond validity." : "";
  const std::string picture = curl_chart(history, result, study, against_length);
  if (against_length)
    return figure("Curl against cast length", picture,
                  "Against the travel of the bottom block." + of_the_plant + of_the_region);
  return figure("Curl against time", picture,
                "Upward displacement of each monitor; time zero is when the bottom block starts." +
                    of_the_band + of_the_plant + of_the_region);
}

namespace {

using FigureOf = double (v1::StepReport::*)() const;

bool is_quarter(const v1::QueryResultResponse& result) {
  return result.case_().section().kind() == v1::Section::QUARTER_SLAB;
}

/// @param also  added to the figure: of two fields of which a step has only one
ChartLine line_of(const v1::QueryResultResponse& result, const std::string& name, FigureOf figure,
                  double factor, FigureOf also = nullptr) {
  ChartLine line{name, {}, {}};
  for (const v1::StepReport& step : result.steps()) {
    line.x.push_back(step.time_s());
    line.y.push_back(factor * ((step.*figure)() + (also != nullptr ? (step.*also)() : 0.0)));
  }
  return line;
}

/// Axis range of a chart without zero: only the range of the data.
bool drawable(const ChartLine& line) {
  return std::ranges::any_of(line.y, [](double y) { return std::isfinite(y) && y != 0.0; });
}

std::string chart_of(const std::string& title, const std::string& unit,
                     std::vector<ChartLine> lines) {
  std::erase_if(lines, [](const ChartLine& line) { return !drawable(line); });
  if (lines.empty()) return {};
  return svg_chart({title + " against time", "time, s", unit, std::move(lines)});
}

std::string figure_if_any(const std::string& heading, const std::string& picture,
                          const std::string& caption) {
  return picture.empty() ? "" : figure(heading, picture, caption);
}

std::string shell_figure(const v1::QueryResultResponse& result) {
  return figure_if_any(
      "Shell",
      chart_of(
          "Shell thickness", "thickness, mm",
          {line_of(result, "of the side at the mould exit", &v1::StepReport::shell_at_exit_m, 1e3),
           line_of(result, "over the bottom, thinnest", &v1::StepReport::bottom_shell_m, 1e3)}),
      "Smallest shell thickness. Until the side leaves the mould: at the butt.");
}

std::string sump_figure(const v1::QueryResultResponse& result) {
  return figure_if_any(
      "Sump",
      chart_of("Sump depth", "depth, mm",
               {line_of(result, "sump", &v1::StepReport::sump_depth_m, 1e3)}),
      "Of the coherency isotherm in the middle of the slab, below the metal level.");
}

/// The monitors' temperatures; a step that does not report one breaks its line.
std::vector<ChartLine> monitor_lines(const v1::QueryResultResponse& result) {
  std::vector<ChartLine> lines;
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  for (const v1::StepReport& step : result.steps())
    for (const v1::MonitorValue& monitor : step.monitors()) {
      auto line = std::ranges::find(lines, monitor.name(), &ChartLine::name);
      if (line == lines.end()) line = lines.insert(lines.end(), {monitor.name(), {}, {}});
      line->x.push_back(step.time_s());
      line->y.push_back(monitor.has_temperature_c() ? monitor.temperature_c() : unknown);
    }
  return lines;
}

std::string temperature_figure(const v1::QueryResultResponse& result) {
  std::vector<ChartLine> lines = monitor_lines(result);
  lines.push_back(line_of(result, "surface at mould exit, hottest",
                          &v1::StepReport::maximum_surface_temperature_at_mould_exit_c, 1.0));
  lines.push_back(line_of(result, "surface of the bottom block, mean",
                          &v1::StepReport::block_temperature_c, 1.0));
  return figure_if_any(
      "Temperatures", chart_of("Temperatures", "°C", std::move(lines)),
      "At the monitors, the hottest surface where it leaves the mould, and the bottom block.");
}

std::string heat_figure(const v1::QueryResultResponse& result) {
  const bool quarter = is_quarter(result);
  std::vector<ChartLine> lines{
      line_of(result, quarter ? "wide face" : "side", &v1::StepReport::side_heat_w_per_m, 1e-3,
              &v1::StepReport::side_heat_w),
      line_of(result, "bottom block", &v1::StepReport::bottom_heat_w_per_m, 1e-3,
              &v1::StepReport::bottom_heat_w)};
  if (quarter)
    lines.insert(lines.begin() + 1,
                 line_of(result, "narrow face", &v1::StepReport::narrow_heat_w_per_m, 1e-3,
                         &v1::StepReport::narrow_heat_w));
  return figure_if_any(
      "Heat through each face",
      chart_of("Heat through each face", quarter ? "kW" : "kW per metre", std::move(lines)),
      quarter ? "Out of the quarter that is computed; four times as much leaves the slab."
              : "Per metre of face, out of the half that is computed.");
}

/// Heat since the start [MJ], from flows [kW] that hold for the step that ends at each time.
ChartLine summed(ChartLine flow, double first_step) {
  double sum = 0.0, before = flow.x.empty() ? 0.0 : flow.x.front() - first_step;
  for (std::size_t i = 0; i < flow.x.size(); ++i) {
    sum += flow.y[i] * (flow.x[i] - before) * 1e-3;
    before = flow.x[i];
    flow.y[i] = sum;
  }
  return flow;
}

/// Where the heat came from and went, as one picture.
std::string balance_figure(const v1::QueryResultResponse& result) {
  const bool quarter = is_quarter(result);
  using Step = v1::StepReport;
  std::vector<ChartLine> lines{
      line_of(result, "brought by the metal", &Step::metal_heat_w_per_m, 1e-3, &Step::metal_heat_w),
      line_of(result, "in the slab", &Step::stored_heat_w_per_m, 1e-3, &Step::stored_heat_w),
      line_of(result, quarter ? "out: wide face" : "out: side", &Step::side_heat_w_per_m, 1e-3,
              &Step::side_heat_w),
      line_of(result, "out: block and gap", &Step::bottom_heat_w_per_m, 1e-3, &Step::bottom_heat_w),
      line_of(result, "in through the metal level", &Step::level_heat_w_per_m, 1e-3,
              &Step::level_heat_w)};
  if (quarter)
    lines.insert(lines.begin() + 3, line_of(result, "out: narrow face", &Step::narrow_heat_w_per_m,
                                            1e-3, &Step::narrow_heat_w));
  const double first_step = result.steps(0).time_step_s();
  for (ChartLine& line : lines) line = summed(std::move(line), first_step);
  return figure_if_any(
      "Where the heat came from and went",
      chart_of("Heat since the start", quarter ? "MJ" : "MJ per metre", std::move(lines)),
      "Above 0 °C, since the start of the run. Metal and level bring what the slab gains and what "
      "leaves through faces and bottom.");
}

std::string water_figure(const v1::QueryResultResponse& result) {
  const bool quarter = is_quarter(result);
  using Step = v1::StepReport;
  std::vector<ChartLine> lines{
      line_of(result, quarter ? "wide face, wetted" : "wetted", &Step::wetted_share, 100.0),
      line_of(result, quarter ? "wide face, of its water's capacity" : "of the water's capacity",
              &Step::water_share, 100.0)};
  if (quarter) {
    lines.push_back(line_of(result, "narrow face, wetted", &Step::narrow_wetted_share, 100.0));
    lines.push_back(
        line_of(result, "narrow face, of its water's capacity", &Step::narrow_water_share, 100.0));
  }
  return figure_if_any("Water on the faces", chart_of("Water on the faces", "%", std::move(lines)),
                       "Share of the face under water that is not under a vapour film, and heat "
                       "taken of all that warming and evaporating the water would take.");
}

std::string contact_figure(const v1::QueryResultResponse& result) {
  const bool quarter = is_quarter(result);
  const ChartLine line = quarter
                             ? line_of(result, "area", &v1::StepReport::contact_area_m2, 1e4)
                             : line_of(result, "length", &v1::StepReport::contact_length_m, 1e3);
  return figure_if_any(
      "Contact with the block",
      chart_of("Contact with the block", quarter ? "area, cm²" : "length, mm", {line}),
      quarter ? "Part of the quarter's bottom in contact with the block."
              : "Part of the bottom in contact with the block.");
}

}  // namespace

std::string history_part(const v1::QueryResultResponse& result) {
  if (result.steps_size() < 2) return {};
  return shell_figure(result) + sump_figure(result) + temperature_figure(result) +
         balance_figure(result) + heat_figure(result) + water_figure(result) +
         contact_figure(result);
}

}  // namespace dccast::client::render
