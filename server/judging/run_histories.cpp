// Charts of a single run against time, beside those of its curls.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <fmt/core.h>

#include "proto/case_file/schedule.hpp"
#include "server/judging/judgement.hpp"
#include "server/judging/run_judgement.hpp"

namespace dccast::judging {
namespace {

using case_file::CastingSchedule, case_file::Face, case_file::Instant;
using Step = v1::StepReport;
using Section = v1::SectionFigures;

/// A figure of a step, or of its section.
class Figure {
public:
  Figure(double (Step::*figure)() const) : of_step_(figure) {}
  Figure(double (Section::*figure)() const) : of_section_(figure) {}

  double operator()(const Step& step) const {
    return of_step_ != nullptr ? (step.*of_step_)() : (step.section().*of_section_)();
  }

private:
  double (Step::*of_step_)() const = nullptr;
  double (Section::*of_section_)() const = nullptr;
};

/// Texts for a section and for a quarter slab.
struct Wording {
  const char* section;
  const char* quarter;

  Wording(const char* both) : section(both), quarter(both) {}
  Wording(const char* for_section, const char* for_quarter)
      : section(for_section), quarter(for_quarter) {}

  const char* choose(const JudgedRun& run) const {
    return run.description.section().kind() == v1::Section::QUARTER_SLAB ? quarter : section;
  }
};

/// A line of a chart: name (null: such a run has none) and figure.
struct History {
  Wording name;
  Figure figure;
};

enum class Drawn {
  figures,
  with_monitors,     ///< and the temperatures of the monitors
  heat_since_start,  ///< flows [W] are summed from the start [J]
};

struct HistoryChart {
  const char* key;
  const char* heading;
  Wording quantity;
  Wording unit;
  std::vector<History> histories;
  Wording note;
  Drawn drawn = Drawn::figures;
  /// The least value that the case permits [m]; null: it has none for these figures.
  double (v1::Plausibility::*least_m)() const = nullptr;
};

const HistoryChart shell_chart{
    "shell",
    "shell",
    "thickness",
    "m",
    {{"of the side at the water line", &Step::shell_at_water_line_m},
     {"of the side above it, thinnest", &Step::least_shell_m},
     {"over the bottom, thinnest", &Step::bottom_shell_m}},
    "Smallest shell thickness; above the water line from the end of the mould contact on. Until "
    "the side leaves the mould: at the butt.",
    Drawn::figures,
    &v1::Plausibility::minimum_shell_m};

const HistoryChart sump_chart{
    "sump",
    "sump",
    "depth",
    "m",
    {{"sump", &Step::sump_depth_m}},
    "Of the coherency isotherm in the middle of the slab, below the metal level."};

const HistoryChart temperatures_chart{
    "temperatures",
    "temperatures",
    "temperature",
    "degC",
    {{"surface at the water line, hottest", &Step::maximum_surface_temperature_at_mould_exit_c},
     {"surface of the bottom block, mean", &Step::block_temperature_c}},
    "At the monitors, the hottest surface at the water line, and the bottom block.",
    Drawn::with_monitors};

const HistoryChart heat_chart{
    "heat",
    "where the heat came from and went",
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
    Drawn::heat_since_start};

const HistoryChart heat_flow_chart{
    "heat_flow",
    "heat through each face",
    "heat flow",
    {"W/m", "W"},
    {{{"side", "wide face"}, &Section::side_heat},
     {{nullptr, "narrow face"}, &Section::narrow_heat},
     {"bottom block", &Section::bottom_heat}},
    {"Per metre of face, out of the half that is computed.",
     "Out of the quarter that is computed; four times as much leaves the slab."}};

const HistoryChart wetting_chart{
    "wetting",
    "water on the faces",
    "share",
    "1",
    {{{"wetted", "wide face, wetted"}, &Step::wetted_share},
     {{"of the water's capacity", "wide face, of its water's capacity"}, &Step::water_share},
     {{nullptr, "narrow face, wetted"}, &Step::narrow_wetted_share},
     {{nullptr, "narrow face, of its water's capacity"}, &Step::narrow_water_share}},
    "Share of the face under water that is not under a vapour film, and heat taken of all that "
    "warming and evaporating the water would take."};

const HistoryChart contact_chart{
    "contact",
    "contact with the block",
    {"length", "area"},
    {"m", "m2"},
    {{{"length", nullptr}, &Step::contact_length_m}, {{nullptr, "area"}, &Step::contact_area_m2}},
    {"Part of the bottom in contact with the block.",
     "Part of the quarter's bottom in contact with the block."}};

/// Charts in the order in which pages show them.
const std::vector<HistoryChart>& history_charts() {
  static const std::vector<HistoryChart> charts{shell_chart,  sump_chart,      temperatures_chart,
                                                heat_chart,   heat_flow_chart, wetting_chart,
                                                contact_chart};
  return charts;
}

/// Temperatures of the monitors; NaN at a step without a value.
void add_monitors(const JudgedRun& run, v1::Chart& chart) {
  const std::vector<double> time_s = run.time_s();
  for (const std::string& name : run.monitors()) {
    std::vector<double> temperature_c;
    for (const Step& step : run.steps) {
      const auto found = std::ranges::find(step.monitors(), name, &v1::MonitorValue::name);
      const bool is_known = found != step.monitors().end() && found->has_temperature_c();
      temperature_c.push_back(is_known ? found->temperature_c()
                                       : std::numeric_limits<double>::quiet_NaN());
    }
    add_line(chart, name, time_s, temperature_c);
  }
}

/// Heat since the start [J], integrated from the flows [W] of the steps.
void sum_up(double first_step_s, v1::Chart::Line& flow) {
  double sum = 0.0;
  double before = flow.x(0) - first_step_s;
  for (int i = 0; i < flow.x_size(); ++i) {
    sum += flow.y(i) * (flow.x(i) - before);
    before = flow.x(i);
    flow.set_y(i, sum);
  }
}

bool shows_nothing(const v1::Chart::Line& line) {
  return std::ranges::none_of(line.y(), [](double y) { return std::isfinite(y) && y != 0.0; });
}

/// Shades the figures that the case permits.
void add_permitted(double least_m, v1::Chart& chart) {
  if (least_m <= 0.0) return;
  v1::Chart::Region& region = *chart.mutable_region();
  region.set_low(least_m);
  region.set_high(std::numeric_limits<double>::infinity());
  region.set_name(fmt::format("{:.4g} mm or more", 1e3 * least_m));
}

/// Adds a chart without those of its lines that are zero throughout; none if all are.
void add_history(const JudgedRun& run, const HistoryChart& history, v1::Judgement& judgement) {
  const std::vector<double> time_s = run.time_s();
  v1::Chart& chart =
      add_chart(judgement, history.key, history.heading,
                {"time", "s", history.quantity.choose(run), history.unit.choose(run)});

  if (history.drawn == Drawn::with_monitors) add_monitors(run, chart);
  for (const auto& [wording, figure] : history.histories) {
    const char* const name = wording.choose(run);
    if (name == nullptr) continue;

    std::vector<double> values;
    std::ranges::transform(run.steps, std::back_inserter(values), figure);
    v1::Chart::Line& line = add_line(chart, name, time_s, values);
    if (history.drawn == Drawn::heat_since_start) sum_up(run.steps.front().time_step_s(), line);
  }

  if (history.least_m != nullptr)
    add_permitted((run.description.plausibility().*history.least_m)(), chart);

  auto& lines = *chart.mutable_lines();
  lines.erase(std::remove_if(lines.begin(), lines.end(), shows_nothing), lines.end());
  if (lines.empty())
    judgement.mutable_parts()->RemoveLast();
  else
    chart.set_note(history.note.choose(run));
}

/// Draws a planned quantity until the casting ends: a slab that cools down is neither cast nor
/// sprayed.
void add_planned(const JudgedRun& run, const std::string& name, v1::Chart& chart,
                 const std::function<double(const Instant&)>& value) {
  constexpr double round_off_s = 1e-6;  // of summed time steps
  const double casting_end_s = run.description.time().end_s() + round_off_s;

  std::vector<double> times_s, values;
  for (const Step& step : run.steps) {
    if (step.time_s() > casting_end_s) break;
    times_s.push_back(step.time_s());
    values.push_back(value({step.time_s(), step.cast_length_m()}));
  }
  add_line(chart, name, times_s, values);
}

void add_speed(const JudgedRun& run, v1::Judgement& judgement) {
  const CastingSchedule plan(run.description);
  v1::Chart& chart =
      add_chart(judgement, "casting_speed", "casting speed", {"time", "s", "casting speed", "m/s"});
  add_planned(run, "casting speed", chart,
              [&](const Instant& instant) { return plan.speed_m_per_s(instant); });
  chart.set_note("As this run had it, factors included.");
}

void add_water(const JudgedRun& run, v1::Judgement& judgement) {
  const CastingSchedule plan(run.description);
  v1::Chart& chart = add_chart(judgement, "water", "water", {"time", "s", "water", "m2/s"});
  const auto add = [&](const char* name, Face face) {
    add_planned(run, name, chart,
                [&](const Instant& instant) { return plan.flow_m2_per_s(face, instant); });
  };

  add(plan.has_narrow_water() ? "wide face" : "water", Face::wide);
  if (plan.has_narrow_water()) add("narrow face", Face::narrow);
  if (plan.has_second_water())
    add_planned(run, "second water", chart,
                [&](const Instant& instant) { return plan.second_flow_m2_per_s(instant); });
  chart.set_note("Litres a minute on a metre of the slab's perimeter, as this run had it.");
}

}  // namespace

void add_histories(const JudgedRun& run, v1::Judgement& judgement) {
  add_speed(run, judgement);
  add_water(run, judgement);
  for (const HistoryChart& history : history_charts()) add_history(run, history, judgement);
}

}  // namespace dccast::judging
