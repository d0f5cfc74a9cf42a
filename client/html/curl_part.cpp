#include "client/html/report_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/core.h>

#include "client/html/html_parts.hpp"
#include "client/html/judgement_parts.hpp"
#include "client/model/answer.hpp"
#include "client/text/findings.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

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

/// The range of curl that the plant wants [m]; a missing end is infinite.
std::optional<v1::Chart::Region> plant_band(const v1::Case& input) {
  const v1::Plausibility& limits = input.plausibility();
  if (!limits.has_least_curl_m() && !limits.has_greatest_curl_m()) return std::nullopt;
  v1::Chart::Region band;
  band.set_low(limits.has_least_curl_m() ? limits.least_curl_m() : -unbounded);
  band.set_high(limits.has_greatest_curl_m() ? limits.greatest_curl_m() : unbounded);
  const std::string low = plant_number(1e3 * band.low()), high = plant_number(1e3 * band.high());

  std::string name = "the plant's band, ";
  if (limits.has_least_curl_m()) name += low + (limits.has_greatest_curl_m() ? " to " : " or more");
  if (limits.has_greatest_curl_m()) name += (limits.has_least_curl_m() ? "" : "up to ") + high;
  band.set_name(name + " mm");
  return band;
}

/// "inside the plant's band, 35 to 45 mm", with a note if the error does not permit this
/// conclusion.
std::string against_band(const v1::Chart::Region& band, double curl_m, const EndError& error) {
  const auto where = [&](double value) {
    return value < band.low() ? "below " : value > band.high() ? "above " : "inside ";
  };
  std::string text = std::string("It is ") + where(curl_m) + html_escaped(band.name());
  if (std::string(where(curl_m - error.lower_m)) != where(curl_m + error.upper_m))
    text += ", but its limit is within the error: this run cannot decide";
  return text + ".";
}

v1::Chart curl_chart(const ReportedRun& run, bool against_length) {
  const CurlHistory& history = run.history;
  const auto& x = against_length ? history.cast_length_m : history.time_s;
  const bool has_limits = !run.study.result().limits().empty();
  v1::Chart chart =
      chart_against(against_length ? "Curl against cast length" : "Curl against time",
                    against_length ? Quantity{"cast length", "m"} : Quantity{"time", "s"},
                    {"curl", "m"});

  for (const auto& series : history.monitors) {
    v1::Chart::Line& line = add_line(chart, series.name);
    for (std::size_t i = 0; i < x.size(); ++i) {
      add_point(line, x[i], series.curl_m[i]);
      if (has_limits || !series.has_error()) continue;
      line.add_low(series.curl_m[i] - series.lower_error_m[i]);
      line.add_high(series.curl_m[i] + series.upper_error_m[i]);
    }
  }
  add_limits(chart, run.study.result(), against_length);

  if (const auto first = history.first_beyond()) chart.set_beyond_x(x[*first]);
  if (const auto band = plant_band(run.result.case_())) *chart.mutable_region() = *band;
  return chart;
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
    text += against_band(*band, curl_m, error.value_or(EndError{0.0, 0.0}));
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
  const v1::Chart chart = curl_chart(run, against_length);
  const std::string region = chart.has_beyond_x() ? " Shaded red: beyond validity." : "";
  if (against_length) return chart_figure(chart, "Against the travel of the bottom block." + region);

  const std::string of_the_band =
      !run.study.result().limits().empty() ? " Shaded: the uncertainty of the limit."
      : has_mesh_error(run)                ? " Shaded: what mesh and time steps leave uncertain."
                                           : "";
  return chart_figure(
      chart, "Upward displacement of each monitor; time zero is when the bottom block starts." +
                 of_the_band + region);
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

/// A line of a chart: name (null if it has none) and figure.
struct Course {
  Wording name;
  FigureOf figure;
};

enum class Drawn {
  figures,
  with_monitors,     ///< and the temperatures of the monitors
  heat_since_start,  ///< flows [W] are summed from the start [J]
};

struct HistoryChart {
  const char* heading;
  Wording quantity, unit;
  std::vector<Course> courses;
  Wording caption;
  Drawn drawn = Drawn::figures;
};

const std::vector<HistoryChart>& history_charts() {
  static const std::vector<HistoryChart> charts{
      {"Shell",
       "thickness",
       "m",
       {{"of the side at the water line", &Step::shell_at_water_line_m},
        {"of the side above it, thinnest", &Step::least_shell_m},
        {"over the bottom, thinnest", &Step::bottom_shell_m}},
       "Smallest shell thickness; above the water line from the end of the mould contact on. Until "
       "the side leaves the mould: at the butt."},
      {"Sump",
       "depth",
       "m",
       {{"sump", &Step::sump_depth_m}},
       "Of the coherency isotherm in the middle of the slab, below the metal level."},
      {"Temperatures",
       "temperature",
       "degC",
       {{"surface at the water line, hottest", &Step::maximum_surface_temperature_at_mould_exit_c},
        {"surface of the bottom block, mean", &Step::block_temperature_c}},
       "At the monitors, the hottest surface at the water line, and the bottom block.",
       Drawn::with_monitors},
      {"Where the heat came from and went",
       "heat since the start",
       {"J/m", "J"},
       {{"brought by the metal", &Section::metal_heat},
        {"in the slab", &Section::stored_heat},
        {{"out: side", "out: wide face"}, &Section::side_heat},
        {{nullptr, "out: narrow face"}, &Section::narrow_heat},
        {"out: block and gap", &Section::bottom_heat},
        {"in through the metal level", &Section::level_heat}},
       "Above 0 °C, since the start of the run. Metal and level bring what the slab gains and what "
       "leaves through faces and bottom.",
       Drawn::heat_since_start},
      {"Heat through each face",
       "heat flow",
       {"W/m", "W"},
       {{{"side", "wide face"}, &Section::side_heat},
        {{nullptr, "narrow face"}, &Section::narrow_heat},
        {"bottom block", &Section::bottom_heat}},
       {"Per metre of face, out of the half that is computed.",
        "Out of the quarter that is computed; four times as much leaves the slab."}},
      {"Water on the faces",
       "share",
       "1",
       {{{"wetted", "wide face, wetted"}, &Step::wetted_share},
        {{"of the water's capacity", "wide face, of its water's capacity"}, &Step::water_share},
        {{nullptr, "narrow face, wetted"}, &Step::narrow_wetted_share},
        {{nullptr, "narrow face, of its water's capacity"}, &Step::narrow_water_share}},
       "Share of the face under water that is not under a vapour film, and heat taken of all that "
       "warming and evaporating the water would take."},
      {"Contact with the block",
       {"length", "area"},
       {"m", "m2"},
       {{{"length", nullptr}, &Step::contact_length_m},
        {{nullptr, "area"}, &Step::contact_area_m2}},
       {"Part of the bottom in contact with the block.",
        "Part of the quarter's bottom in contact with the block."}}};
  return charts;
}

void add_course(v1::Chart& chart, const v1::QueryResultResponse& result, const char* name,
                const FigureOf& figure) {
  v1::Chart::Line& line = add_line(chart, name);
  for (const Step& step : result.steps()) add_point(line, step.time_s(), figure(step));
}

/// Temperatures of the monitors; a step without a value interrupts the line.
void add_monitors(v1::Chart& chart, const v1::QueryResultResponse& result) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  for (const Step& step : result.steps())
    for (const v1::MonitorValue& monitor : step.monitors()) {
      auto& lines = *chart.mutable_lines();
      const auto known = std::ranges::find(lines, monitor.name(), &v1::Chart::Line::name);
      v1::Chart::Line& line = known == lines.end() ? add_line(chart, monitor.name()) : *known;
      add_point(line, step.time_s(), monitor.has_temperature_c() ? monitor.temperature_c() : unknown);
    }
}

/// Heat since the start [J], integrated from the flows [W] of the steps.
void sum_up(v1::Chart::Line& flow, double first_step_s) {
  double sum = 0.0, before = flow.x(0) - first_step_s;
  for (int i = 0; i < flow.x_size(); ++i) {
    sum += flow.y(i) * (flow.x(i) - before);
    before = flow.x(i);
    flow.set_y(i, sum);
  }
}

/// Empty if all its figures are zero.
std::string history_figure(const v1::QueryResultResponse& result, const HistoryChart& history) {
  const bool is_quarter = result.case_().section().kind() == v1::Section::QUARTER_SLAB;
  const auto wording = [&](const Wording& of) { return is_quarter ? of.quarter : of.section; };
  v1::Chart chart = chart_against(history.heading, {"time", "s"},
                                  {wording(history.quantity), wording(history.unit)});

  if (history.drawn == Drawn::with_monitors) add_monitors(chart, result);
  for (const Course& course : history.courses) {
    const char* const name = wording(course.name);
    if (name == nullptr) continue;
    add_course(chart, result, name, course.figure);
    if (history.drawn == Drawn::heat_since_start)
      sum_up(*chart.mutable_lines(chart.lines_size() - 1), result.steps(0).time_step_s());
  }

  auto& lines = *chart.mutable_lines();
  const auto is_empty = [](const v1::Chart::Line& line) {
    return std::ranges::none_of(line.y(), [](double y) { return std::isfinite(y) && y != 0.0; });
  };
  lines.erase(std::remove_if(lines.begin(), lines.end(), is_empty), lines.end());
  return chart.lines().empty() ? "" : chart_figure(chart, wording(history.caption));
}

}  // namespace

std::string history_part(const v1::QueryResultResponse& result) {
  std::string html;
  if (result.steps_size() < 2) return html;
  for (const HistoryChart& history : history_charts()) html += history_figure(result, history);
  return html;
}

}  // namespace dccast::client::render
