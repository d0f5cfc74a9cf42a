#include "client/html/report_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/core.h>

#include "client/html/html_parts.hpp"
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

/// How far the true curl of this run may lie below and above its end: by its study, else by its
/// quality [m].
struct EndError {
  double lower_m, upper_m;
};
std::optional<EndError> end_error(const ReportedRun& run, const CurlHistory::Series& series) {
  const double curl = series.curl_m.back();
  if (const auto error =
          curl_error(run.study.result(), series.name, run.history.time_s.back(), curl))
    return EndError{error->this_run_m, error->this_run_m};
  if (!series.has_error()) return std::nullopt;
  return EndError{series.lower_error_m.back(), series.upper_error_m.back()};
}

/// Whether mesh and steps of the case's quality leave a known error.
bool has_mesh_error(const ReportedRun& run) {
  return std::ranges::any_of(run.history.monitors, &CurlHistory::Series::has_error);
}

/// The plant's range [mm]; a missing end is infinite.
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

/// "inside the plant's band, 35 to 45 mm", with a note if the error does not permit this
/// conclusion.
std::string against_band(const Chart::Wanted& band, double curl_mm, const EndError& error) {
  const auto where = [&](double value) {
    return value < band.low ? "below " : value > band.high ? "above " : "inside ";
  };
  std::string text = std::string("It is ") + where(curl_mm) + html_escaped(band.name);
  if (std::string(where(curl_mm - 1e3 * error.lower_m)) != where(curl_mm + 1e3 * error.upper_m))
    text += ", but its limit is within the error: this run cannot decide";
  return text + ".";
}

std::string curl_chart(const ReportedRun& run, bool against_length) {
  Chart chart{against_length ? "Butt curl against cast length" : "Butt curl against time",
              against_length ? "cast length, mm" : "time, s",
              "curl, mm",
              {}};
  const auto x = against_length ? millimetres(run.history.cast_length_m) : run.history.time_s;
  for (const auto& series : run.history.monitors) {
    ChartLine line{series.name, x, millimetres(series.curl_m),
                   curl_band(run.study.result(), series.name, against_length)};
    if (run.study.result().limits().empty() && series.has_error())
      line.band =
          band_around(line, millimetres(series.lower_error_m), millimetres(series.upper_error_m));
    chart.lines.push_back(std::move(line));
  }
  if (const auto first = run.history.first_beyond()) {
    chart.beyond_from = x[*first];
    chart.beyond_name = beyond_validity;
  }
  chart.wanted = plant_band(run.result.case_());
  return svg_chart(chart);
}

std::string tile(const std::string& name, const std::string& value, const std::string& unit,
                 const std::string& note = {}) {
  return fmt::format("<div class='tile'><span>{}</span><strong>{}</strong> {}{}</div>",
                     html_escaped(name), value, unit, note.empty() ? "" : element("small", note));
}

/// The final curl, with its error where a study or the quality gives it.
std::string curl_tile(const ReportedRun& run, const CurlHistory::Series& series) {
  const double curl = series.curl_m.back();
  std::string note;
  if (const auto band = end_error(run, series))
    note = "<em>" + mm_errors(band->lower_m, band->upper_m, 2) + " mm</em>";
  if (const auto error =
          curl_error(run.study.result(), series.name, run.history.time_s.back(), curl))
    note += (error->extrapolated ? "limit " : "finest ") + mm(error->limit_m, 2) + " ± " +
            mm(error->uncertainty_m, 2);
  const std::string mark = last_step_mark(run.history);
  if (!note.empty() && !mark.empty()) note += "<br>";
  return tile("curl, " + series.name, mm(curl, 2), "mm", note + mark);
}

}  // namespace

std::string last_step_mark(const CurlHistory& history) {
  return !history.beyond.empty() && history.beyond.back() ? beyond_validity : "";
}

std::string curl_sentence(const ReportedRun& run) {
  const CurlHistory::Series* const largest = run.history.largest();
  if (largest == nullptr || !last_step_mark(run.history).empty()) return {};
  const double curl_m = largest->curl_m.back();
  const auto error = end_error(run, *largest);
  std::string text = fmt::format(
      "At {} s, after {} mm of casting, {} has {} <strong>{} mm</strong> since the block started. ",
      fixed(run.history.time_s.back(), 0), mm(run.history.cast_length_m.back(), 0),
      html_escaped(largest->name), curl_m < 0.0 ? "sunk" : "risen", mm(std::abs(curl_m)));
  text += error ? "Mesh and time steps leave " + mm_errors(error->lower_m, error->upper_m, 1) +
                      " mm of it uncertain; thermal data and alloy come on top. "
                : "Its error from mesh and time steps has not been measured: <code>dccast "
                  "convergence</code> does that. ";
  if (const auto band = plant_band(run.result.case_()))
    text += against_band(*band, 1e3 * curl_m, error.value_or(EndError{0.0, 0.0}));
  return element("p class='answer'", text);
}

namespace {

/// The last step at which a curl is below this share of its final value.
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
    heat.faces += step.time_step_s() * (step.section().side_heat() + step.section().narrow_heat());
    heat.bottom += step.time_step_s() * step.section().bottom_heat();
  }
  return heat;
}

/// "40 to 98 %", or "98 %".
std::string range_of_percent(double first, double last) {
  const std::string begin = fixed(100.0 * first, 0), end = fixed(100.0 * last, 0);
  return (begin == end ? "" : begin + " to ") + end + " %";
}

}  // namespace

std::string cause_sentence(const ReportedRun& run) {
  constexpr double nothing = 1e-4;  // [m]
  const CurlHistory::Series* const largest = run.history.largest();
  if (largest == nullptr || !last_step_mark(run.history).empty() ||
      std::abs(largest->curl_m.back()) < nothing)
    return {};
  const std::size_t first = last_below(largest->curl_m, 0.25),
                    last = last_below(largest->curl_m, 0.75);
  std::string text =
      fmt::format("Half of it came between {} s and {} s, at {} to {} mm of casting. ",
                  fixed(run.history.time_s[first], 0), fixed(run.history.time_s[last], 0),
                  mm(run.history.cast_length_m[first], 0), mm(run.history.cast_length_m[last], 0));
  const Heat heat = heat_between(run.history.reports, first, last);
  if (const double all = heat.faces + heat.bottom; heat.faces > 0.0 && heat.bottom > 0.0)
    text += fmt::format(
        "Meanwhile {} % of the heat left through the faces, to mould and water, and {} % through "
        "the bottom, to the block. ",
        fixed(100.0 * heat.faces / all, 0), fixed(100.0 * heat.bottom / all, 0));
  if (run.result.case_().cooling().water().enabled() &&
      run.history.reports[last].wetted_share() > 0.0)
    text += fmt::format("Water wetted {} of the side under the water line.",
                        range_of_percent(run.history.reports[first].wetted_share(),
                                         run.history.reports[last].wetted_share()));
  return element("p class='cause'", text);
}

std::string headline(const ReportedRun& run) {
  if (run.history.time_s.empty()) return "<p>The job has no step yet.</p>";
  std::string tiles;
  for (const auto& series : run.history.monitors) tiles += curl_tile(run, series);
  const std::string mark = last_step_mark(run.history);
  const v1::StepReport& last = run.result.steps(run.result.steps_size() - 1);
  tiles += tile("cast length", mm(last.cast_length_m()), "mm") +
           tile("time", fixed(last.time_s(), 1), "s");
  if (run.result.case_().section().kind() == v1::Section::QUARTER_SLAB)
    tiles += tile("stands on the block", fixed(1e4 * last.contact_area_m2(), 0), "cm²", mark);
  else
    tiles += tile("stands on the block", mm(last.contact_length_m(), 0), "mm", mark);
  tiles += tile("sump depth", mm(last.sump_depth_m(), 0), "mm", mark);
  return "<div class='tiles'>" + tiles + "</div>";
}

std::string curl_figure(const ReportedRun& run, bool against_length) {
  if (run.history.monitors.empty()) return {};
  const std::string of_the_band =
      !run.study.result().limits().empty()
          ? " Dashed: the limit of finer meshes; shaded: its uncertainty."
      : has_mesh_error(run) ? " Shaded: what mesh and time steps leave uncertain."
                            : "";
  const std::string of_the_plant =
      plant_band(run.result.case_()) ? " Green: the plant's band." : "";
  const std::string of_the_region =
      run.history.first_beyond() ? " Shaded red: beyond validity." : "";
  const std::string picture = curl_chart(run, against_length);
  if (against_length)
    return figure("Curl against cast length", picture,
                  "Against the travel of the bottom block." + of_the_plant + of_the_region);
  return figure("Curl against time", picture,
                "Upward displacement of each monitor; time zero is when the bottom block starts." +
                    of_the_band + of_the_plant + of_the_region);
}

namespace {

using Step = v1::StepReport;
using Section = v1::SectionFigures;

/// A figure of a step, or of its section.
class FigureOf {
public:
  FigureOf(double (Step::*figure)() const) : of_step_(figure) {}
  FigureOf(double (Section::*figure)() const) : of_section_(figure) {}

  double operator()(const Step& step) const {
    return of_step_ != nullptr ? (step.*of_step_)() : (step.section().*of_section_)();
  }

private:
  double (Step::*of_step_)() const = nullptr;
  double (Section::*of_section_)() const = nullptr;
};

/// Texts for a section and for a quarter slab.
struct Wording {
  const char *section, *quarter;

  Wording(const char* both) : section(both), quarter(both) {}
  Wording(const char* of_section, const char* of_quarter)
      : section(of_section), quarter(of_quarter) {}
};

/// A line of a chart: name (null if it has none), figure, and factor to its unit.
struct Course {
  Wording name;
  double factor;
  FigureOf figure;
};

enum class Drawn {
  figures,
  with_monitors,     ///< and the temperatures of the monitors
  heat_since_start,  ///< flows [kW] are summed from the start [MJ]
};

struct HistoryChart {
  const char *heading, *title;
  Wording unit;
  std::vector<Course> courses;
  Wording caption;
  Drawn drawn = Drawn::figures;
};

const std::vector<HistoryChart>& history_charts() {
  static const std::vector<HistoryChart> charts{
      {"Shell",
       "Shell thickness",
       "thickness, mm",
       {{"of the side at the water line", 1e3, &Step::shell_at_water_line_m},
        {"of the side above it, thinnest", 1e3, &Step::least_shell_m},
        {"over the bottom, thinnest", 1e3, &Step::bottom_shell_m}},
       "Smallest shell thickness; above the water line from the end of the mould contact on. Until "
       "the side leaves the mould: at the butt."},
      {"Sump",
       "Sump depth",
       "depth, mm",
       {{"sump", 1e3, &Step::sump_depth_m}},
       "Of the coherency isotherm in the middle of the slab, below the metal level."},
      {"Temperatures",
       "Temperatures",
       "°C",
       {{"surface at the water line, hottest", 1.0,
         &Step::maximum_surface_temperature_at_mould_exit_c},
        {"surface of the bottom block, mean", 1.0, &Step::block_temperature_c}},
       "At the monitors, the hottest surface at the water line, and the bottom block.",
       Drawn::with_monitors},
      {"Where the heat came from and went",
       "Heat since the start",
       {"MJ per metre", "MJ"},
       {{"brought by the metal", 1e-3, &Section::metal_heat},
        {"in the slab", 1e-3, &Section::stored_heat},
        {{"out: side", "out: wide face"}, 1e-3, &Section::side_heat},
        {{nullptr, "out: narrow face"}, 1e-3, &Section::narrow_heat},
        {"out: block and gap", 1e-3, &Section::bottom_heat},
        {"in through the metal level", 1e-3, &Section::level_heat}},
       "Above 0 °C, since the start of the run. Metal and level bring what the slab gains and what "
       "leaves through faces and bottom.",
       Drawn::heat_since_start},
      {"Heat through each face",
       "Heat through each face",
       {"kW per metre", "kW"},
       {{{"side", "wide face"}, 1e-3, &Section::side_heat},
        {{nullptr, "narrow face"}, 1e-3, &Section::narrow_heat},
        {"bottom block", 1e-3, &Section::bottom_heat}},
       {"Per metre of face, out of the half that is computed.",
        "Out of the quarter that is computed; four times as much leaves the slab."}},
      {"Water on the faces",
       "Water on the faces",
       "%",
       {{{"wetted", "wide face, wetted"}, 100.0, &Step::wetted_share},
        {{"of the water's capacity", "wide face, of its water's capacity"},
         100.0,
         &Step::water_share},
        {{nullptr, "narrow face, wetted"}, 100.0, &Step::narrow_wetted_share},
        {{nullptr, "narrow face, of its water's capacity"}, 100.0, &Step::narrow_water_share}},
       "Share of the face under water that is not under a vapour film, and heat taken of all that "
       "warming and evaporating the water would take."},
      {"Contact with the block",
       "Contact with the block",
       {"length, mm", "area, cm²"},
       {{{"length", nullptr}, 1e3, &Step::contact_length_m},
        {{nullptr, "area"}, 1e4, &Step::contact_area_m2}},
       {"Part of the bottom in contact with the block.",
        "Part of the quarter's bottom in contact with the block."}}};
  return charts;
}

ChartLine line_of(const v1::QueryResultResponse& result, const char* name, const Course& course) {
  ChartLine line{name, {}, {}};
  for (const Step& step : result.steps()) {
    line.x.push_back(step.time_s());
    line.y.push_back(course.factor * course.figure(step));
  }
  return line;
}

/// Temperatures of the monitors; a step without a value interrupts the line.
std::vector<ChartLine> monitor_lines(const v1::QueryResultResponse& result) {
  std::vector<ChartLine> lines;
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  for (const Step& step : result.steps())
    for (const v1::MonitorValue& monitor : step.monitors()) {
      auto line = std::ranges::find(lines, monitor.name(), &ChartLine::name);
      if (line == lines.end()) line = lines.insert(lines.end(), {monitor.name(), {}, {}});
      line->x.push_back(step.time_s());
      line->y.push_back(monitor.has_temperature_c() ? monitor.temperature_c() : unknown);
    }
  return lines;
}

/// Heat since the start [MJ], integrated from the flows [kW] of the steps.
void sum_up(ChartLine& flow, double first_step) {
  double sum = 0.0, before = flow.x.front() - first_step;
  for (std::size_t i = 0; i < flow.x.size(); ++i) {
    sum += flow.y[i] * (flow.x[i] - before) * 1e-3;
    before = flow.x[i];
    flow.y[i] = sum;
  }
}

/// Empty if all its figures are zero.
std::string history_figure(const v1::QueryResultResponse& result, const HistoryChart& chart) {
  const bool is_quarter = result.case_().section().kind() == v1::Section::QUARTER_SLAB;
  const auto wording = [&](const Wording& of) { return is_quarter ? of.quarter : of.section; };
  std::vector<ChartLine> lines;
  if (chart.drawn == Drawn::with_monitors) lines = monitor_lines(result);
  for (const Course& course : chart.courses)
    if (const char* const name = wording(course.name)) {
      lines.push_back(line_of(result, name, course));
      if (chart.drawn == Drawn::heat_since_start)
        sum_up(lines.back(), result.steps(0).time_step_s());
    }
  std::erase_if(lines, [](const ChartLine& line) {
    return std::ranges::none_of(line.y, [](double y) { return std::isfinite(y) && y != 0.0; });
  });
  if (lines.empty()) return {};
  return figure(chart.heading,
                svg_chart({std::string(chart.title) + " against time", "time, s",
                           wording(chart.unit), std::move(lines)}),
                wording(chart.caption));
}

}  // namespace

std::string history_part(const v1::QueryResultResponse& result) {
  std::string html;
  if (result.steps_size() < 2) return html;
  for (const HistoryChart& chart : history_charts()) html += history_figure(result, chart);
  return html;
}

}  // namespace dccast::client::render
