#include <algorithm>
#include <cmath>
#include <ostream>

#include <fmt/core.h>

#include "client/html/html_parts.hpp"
#include "client/html/judgement_parts.hpp"
#include "client/html/pages.hpp"
#include "client/html/report_parts.hpp"
#include "client/model/answer.hpp"
#include "client/session/jobs.hpp"
#include "client/session/studies.hpp"
#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "proto/frames/contraction.hpp"

namespace dccast::client::render {
namespace {

bool is_quarter(const v1::Case& input) {
  return input.section().kind() == v1::Section::QUARTER_SLAB;
}

/// Describes factor and shift of a table; empty if they have no effect.
std::string changes(const v1::Curve& factor, double shift_s) {
  std::string text;
  if (factor.value_size() > 1 || (factor.value_size() == 1 && factor.value(0) != 1.0))
    text += "times " + curve_in_words(factor, 1.0, "");
  if (shift_s != 0.0)
    text += (text.empty() ? "" : "; ") + plant_number(std::abs(shift_s)) + " s " +
            (shift_s > 0.0 ? "later" : "earlier");
  return text;
}

std::string size_text(const v1::Section& section) {
  const std::string width = plant_number(2e3 * section.half_width_m());
  if (section.kind() == v1::Section::AXISYMMETRIC) return width + " mm in diameter";
  if (section.kind() != v1::Section::QUARTER_SLAB) return width + " mm across";
  const auto& half_thickness_m = section.half_thickness_m().value();
  return width + " × " + plant_mm(half_thickness_m.empty() ? 0.0 : 2.0 * half_thickness_m[0]);
}

const v1::Curve& narrow_flow(const v1::Case& input) {
  const v1::Schedule& recipe = input.schedule();
  return recipe.has_narrow_water_flow_m2_per_s() ? recipe.narrow_water_flow_m2_per_s()
                                                 : recipe.water_flow_m2_per_s();
}

const v1::Water& narrow_water(const v1::Case& input) {
  return input.cooling().has_narrow_water() ? input.cooling().narrow_water()
                                            : input.cooling().water();
}

bool narrow_differs(const v1::Case& input) {
  return is_quarter(input) &&
         (input.schedule().has_narrow_water_flow_m2_per_s() || input.cooling().has_narrow_water());
}

std::string water_note(const v1::Water& water) {
  if (!water.enabled()) return "turned off";
  return fmt::format("from {} s on, {} below the metal level, at {}", plant_number(water.start_s()),
                     plant_mm(water.from_m()), curve_in_words(water.temperature_c(), 1.0, "°C"));
}

std::string water_rows(const v1::Case& input) {
  const v1::Schedule& recipe = input.schedule();
  const std::string changed = changes(recipe.water_flow_factor(), recipe.water_flow_shift_s());
  const auto one = [&](const std::string& name, const v1::Curve& flow, const v1::Water& water) {
    return row(name, curve_in_words(flow, litres_per_min_per_m, "l/min/m"),
               water_note(water) + (changed.empty() ? "" : "; " + changed));
  };
  const bool two = narrow_differs(input);
  return one(two ? "Water, wide face" : "Water", recipe.water_flow_m2_per_s(),
             input.cooling().water()) +
         (two ? one("Water, narrow face", narrow_flow(input), narrow_water(input)) : "");
}

std::string recipe_table(const v1::Case& input) {
  const v1::Schedule& recipe = input.schedule();
  const v1::Section& section = input.section();
  const auto celsius = [](const v1::Curve& curve) { return curve_in_words(curve, 1.0, "°C"); };
  const std::string rows =
      row(section.kind() == v1::Section::AXISYMMETRIC ? "Billet" : "Slab", size_text(section),
          "metal stands " + plant_mm(section.initial_depth_m()) + " deep at the start") +
      row("Alloy", html_escaped(input.alloy().card()),
          fmt::format("solidus {} °C, liquidus {} °C", plant_number(input.alloy().solidus_c()),
                      plant_number(input.alloy().liquidus_c()))) +
      row("Hold before the block moves", plant_number(recipe.hold_s()) + " s",
          "the shell forms; t = 0 is when the block starts") +
      row("Casting speed", curve_in_words(recipe.casting_speed_m_per_s(), mm_per_min, "mm/min"),
          changes(recipe.casting_speed_factor(), recipe.casting_speed_shift_s())) +
      row("Casting temperature", celsius(recipe.casting_temperature_c())) + water_rows(input) +
      row("Bottom block", celsius(input.cooling().bottom_block().temperature_c()));
  return element("table", rows);
}

/// Adds a table of the schedule with factor and shift, against time, until the casting ends: a slab
/// that cools down is neither cast nor sprayed. @param acts  whether it takes effect at a time [s];
/// the value is zero where it does not
template <class Acts>
void add_course(v1::Chart& chart, const std::string& name, const v1::QueryResultResponse& result,
                const v1::Curve& table, const v1::Curve& factor, double shift_s, const Acts& acts) {
  constexpr double round_off = 1e-6;  // [s] of summed time steps
  const double casting_end_s = result.case_().time().end_s() + round_off;
  v1::Chart::Line& line = add_line(chart, name);
  for (const v1::StepReport& step : result.steps()) {
    const double t = step.time_s(), length = step.cast_length_m();
    if (t > casting_end_s) break;
    add_point(line, t,
              acts(t) ? frames::curve_value(factor, t, length, 1.0) *
                            frames::curve_value(table, t - shift_s, length, 0.0)
                      : 0.0);
  }
}

v1::Chart speed_chart(const v1::QueryResultResponse& result) {
  const v1::Schedule& recipe = result.case_().schedule();
  v1::Chart chart = chart_against("Casting speed", {"time", "s"}, {"casting speed", "m/s"});
  // The block does not move during the hold, independent of the table.
  add_course(chart, "casting speed", result, recipe.casting_speed_m_per_s(),
             recipe.casting_speed_factor(), recipe.casting_speed_shift_s(),
             [](double time_s) { return time_s > 0.0; });
  return chart;
}

v1::Chart water_chart(const v1::QueryResultResponse& result) {
  const v1::Case& input = result.case_();
  const v1::Schedule& recipe = input.schedule();
  v1::Chart chart = chart_against("Water", {"time", "s"}, {"water", "m2/s"});
  const auto add = [&](const std::string& name, const v1::Curve& flow, const v1::Water& water) {
    add_course(
        chart, name, result, flow, recipe.water_flow_factor(), recipe.water_flow_shift_s(),
        [&](double time_s) { return water.enabled() && time_s >= water.start_s(); });
  };
  const bool two = narrow_differs(input);
  add(two ? "wide face" : "water", recipe.water_flow_m2_per_s(), input.cooling().water());
  if (two) add("narrow face", narrow_flow(input), narrow_water(input));
  return chart;
}

std::string recipe_part(const v1::QueryResultResponse& result) {
  if (!result.has_case_()) return {};
  return card("Recipe", recipe_table(result.case_()));
}

/// Charts of speed and water in this run. Empty with fewer than two steps.
std::string recipe_charts(const v1::QueryResultResponse& result) {
  if (!result.has_case_() || result.steps_size() < 2) return {};
  return chart_figure(speed_chart(result), "As this run had it, factors included.") +
         chart_figure(
             water_chart(result),
             "Litres a minute on a metre of the slab's perimeter, as this run had it.");
}

std::string scientific(double value) {
  if (!std::isfinite(value)) return "-";
  return value == 0.0 ? "0" : fmt::format("{:.2e}", value);
}

using Step = v1::StepReport;

std::string checks_table(const v1::QueryResultResponse& result, const CurlHistory& history) {
  if (result.steps_size() == 0) return {};
  const v1::StepReport& last = result.steps(result.steps_size() - 1);
  const std::string mark = last_step_mark(history);
  const std::string of_last_step = "last step" + (mark.empty() ? "" : ", " + mark);
  const bool quarter = is_quarter(result.case_());
  const std::string per_metre = quarter ? "" : "/m";
  const auto worst = [&](const std::string& name, double (Step::*figure_of)() const,
                         const std::string& note) {
    double largest = 0.0;
    for (const Step& step : result.steps())
      largest = std::max(largest, std::abs((step.*figure_of)()));
    return row(name, scientific(largest), note);
  };
  const double reaction = last.section().bottom_reaction();
  const double weight = last.section().weight();
  const double heat = last.section().wall_heat_flux();
  const std::string rows =
      worst("Equilibrium residual", &Step::equilibrium_residual, "largest of all steps, relative") +
      worst("Energy balance", &Step::energy_balance_error, "largest of all steps, relative") +
      worst("Complementarity", &Step::complementarity_error, "gap times pressure, relative") +
      worst("Constitutive residual", &Step::constitutive_residual, "relative") +
      row("Pressure on the liquidus front", scientific(last.liquid_pressure_error()),
          "against the metallostatic one, relative, " + of_last_step) +
      row("Bottom reaction", fixed(reaction, 1) + " N" + per_metre,
          "weight " + fixed(weight, 1) + " N" + per_metre + ", " + of_last_step) +
      row("Heat through side and bottom", fixed(1e-3 * heat, 1) + " kW" + per_metre,
          (quarter ? "of the quarter, " : "per metre of face, ") + of_last_step);
  return card("Checks of the run", element("table", rows));
}

std::string run_table(const v1::Job& job, const v1::QueryResultResponse& result) {
  std::string rows = row("State", full_state_text(job)) + row("Job", html_escaped(job.id())) +
                     row("Study", job.study().empty() ? "none" : html_escaped(job.study())) +
                     row("Ended", time_text(job.end_time())) +
                     row("Case SHA-256", element("code", html_escaped(job.case_sha256())));
  if (result.steps_size() > 0) {
    const v1::StepReport& last = result.steps(result.steps_size() - 1);
    double iterations = 0.0, cut = 0.0;
    for (const v1::StepReport& step : result.steps()) {
      iterations += step.iterations();
      cut += step.failed_attempts();
    }
    rows +=
        row("Steps", std::to_string(result.steps_size()), fixed(cut, 0) + " attempts were cut") +
        row("Mechanical iterations", fixed(iterations, 0),
            fixed(iterations / result.steps_size(), 2) + " a step") +
        row("Mesh at the end", std::to_string(last.nodes()) + " nodes",
            std::to_string(last.elements()) + " elements") +
        row("Solver time", duration_text(last.solver_s()));
  }
  if (job.has_failure()) rows += row("Failure", html_escaped(failure_text(job.failure())));
  return card("Run", element("table", rows));
}

std::string element_row(v1::ElementKind element) {
  if (element == v1::P1)
    return row("Element", "p1", "linear triangles lock on coarse meshes: compare with q1_bending");
  if (element == v1::Q1)
    return row("Element", "q1", "long cells resist bending: compare with q1_bending");
  return row("Element", "q1_bending");
}

std::string coherency_text(const v1::Alloy& alloy) {
  if (alloy.has_coherency_solid_fraction())
    return "solid fraction " + fixed(alloy.coherency_solid_fraction(), 2);
  return fixed(alloy.has_coherency_c() ? alloy.coherency_c() : alloy.liquidus_c(), 0) + " °C";
}

std::string inputs_table(const v1::QueryResultResponse& result) {
  if (!result.has_case_()) return {};
  const v1::Case& input = result.case_();
  const v1::Alloy& alloy = input.alloy();
  const std::string rows =
      row("Mechanics starts", fixed(input.mechanics().start_s(), 1) + " s",
          "from a stress-free shell: what happened before leaves no curl") +
      row("Coherency", coherency_text(alloy),
          fmt::format("below it the mush transmits stress; solidus {}, liquidus {} °C",
                      fixed(alloy.solidus_c(), 0), fixed(alloy.liquidus_c(), 0))) +
      row("Alloy card", html_escaped(alloy.card() + " (" + alloy.provenance() + ")"),
          html_escaped(alloy.description())) +
      row("Half width", mm(input.section().half_width_m(), 0) + " mm") +
      element_row(input.mesh().element()) +
      row("Algorithm", v1::Mechanics::Algorithm_Name(input.mechanics().algorithm()));
  return card("What the result rests on",
              element("table", rows) +
                  "<details><summary>The whole case, with all defaults</summary>" +
                  element("pre", html_escaped(readable_toml(input))) + "</details>");
}

/// The sentence at the top of the page of a job that failed, unless validity_banner() names the
/// cause.
std::string failure_banner(const v1::Job& job) {
  if (!job.has_failure() || job.has_validity_loss()) return {};
  return element("p class='invalid'",
                 "The run failed: " + html_escaped(failure_text(job.failure())));
}

/// The sentence at the top of a page with figures beyond validity.
std::string validity_banner(const v1::Job& job, const CurlHistory& history) {
  const auto first = history.first_beyond();
  if (!first && !job.has_validity_loss()) return {};
  const std::string loss = job.has_validity_loss() ? validity_text(job.validity_loss())
                                                   : std::string(beyond_validity) + " from " +
                                                         fixed(history.time_s[*first], 2) + " s on";
  return element("p class='invalid'",
                 "This run is " + html_escaped(loss) +
                     ". Figures after that time are marked; they are not valid.");
}

/// "1 danger, 2 warnings" beside the state.
std::string findings_mark(const v1::Job& job) {
  if (job.findings().empty()) return {};
  const bool danger = std::ranges::any_of(job.findings(), [](const auto& finding) {
    return finding.severity() == v1::Finding::DANGER;
  });
  return std::string(" · <span class='state") + (danger ? " failed" : "") + "'>" +
         findings_count(job.findings()) + "</span>";
}

std::string page_header(const v1::Job& job, const std::string& title) {
  return fmt::format(
      "<p class='kicker'>dccast report · job {0} · <span class='state {1}'>{1}</span>{2}</p>"
      "<h1>{3}</h1>",
      html_escaped(job.id().substr(0, 8)), state_text(job.state()), findings_mark(job), title);
}

/// The part for the plant, printed on one sheet.
std::string first_sheet(const ReportedRun& run, const FrameSeries& series) {
  return "<div class='first'>" + failure_banner(run.job) + validity_banner(run.job, run.history) +
         curl_sentence(run) + cause_sentence(run) + findings_part(run.job.findings()) +
         headline(run) + "<div class='cards'>" + curl_figure(run, false) + recipe_part(run.result) +
         frame_part(run.result, run.history, series) + "</div></div>";
}

/// The histories of the run.
std::string details(const ReportedRun& run) {
  return "<div class='histories'><div class='cards'>" + curl_figure(run, true) +
         recipe_charts(run.result) + history_part(run.result) +
         bottom_part(run.result, run.history) + "</div></div>";
}

/// Known discretisation error, from the study or else from the quality of the case.
std::string discretisation_part(const ReportedRun& run) {
  if (run.history.monitors.empty()) return {};
  if (run.study.result().limits().empty() &&
      std::ranges::any_of(run.history.monitors, &CurlHistory::Series::has_error))
    return "<p class='note'>The ± beside a curl is the band of the case's quality "
           "(docs/error-bars.md). <code>dccast convergence CASE</code> shows it for this case.</p>";
  return study_part(run.study, run.job);
}

/// The evidence: error, checks of the run, progress, assumptions and the whole case.
std::string evidence(const ReportedRun& run) {
  return "<div class='evidence'>" + discretisation_part(run) + "<div class='cards'>" +
         checks_table(run.result, run.history) + run_table(run.job, run.result) +
         inputs_table(run.result) + "</div></div>";
}

/// The result with the last frame; without the frame if there is none, if it exceeds a response, or
/// if the stored results cannot be read.
v1::QueryResultResponse result_of(Connection& connection, const std::string& id,
                                  std::ostream& notes, grpc::Status& status) {
  v1::QueryResultResponse result;
  status = try_query_result(connection, id, true, result);
  if (status.ok()) return result;
  notes << "dccast: " << status.error_message()
        << "; the report goes without a picture of the slab\n";
  return query_result(connection, id);
}

/// As many frames as keep the page so small that it can be mailed.
FrameSeries frames_of_page(Connection& connection, const std::string& id,
                           const v1::QueryResultResponse& result) {
  constexpr int most_frames = 25;
  constexpr double most_bytes = 1e6;
  if (!result.has_frame()) return {};
  // The slab grows, so a frame has half the nodes of the last one on average. A node takes some 25
  // characters, with its share of the elements.
  const double nodes = result.frame().temperature_c_size();
  const int fitting = static_cast<int>(most_bytes / (0.5 * 25.0 * nodes + 1.0));
  return fetch_frames(connection, id, result, std::clamp(fitting, 1, most_frames));
}

}  // namespace

std::string report_page(const v1::Job& job, const v1::QueryResultResponse& result,
                        const v1::StudyJudgement& study, const FrameSeries& series) {
  const ReportedRun run{job, result, study, curl_history(job, result)};
  const std::string title = html_escaped(job.title().empty() ? "Casting " + job.id() : job.title());
  return whole_page(title, page_header(job, title),
                    first_sheet(run, series) + details(run) + evidence(run));
}

std::string casting_page(const v1::Case& complete) {
  const std::string title = html_escaped(complete.title());
  return whole_page(title, element("h1", title),
                    element("p class='answer'", html_escaped(casting_summary(complete))) +
                        card("Start of the casting", drawn("casting", to_json(complete))));
}

std::string report_of(Connection& connection, const v1::Job& job, std::ostream& notes,
                      grpc::Status& frame_status) {
  const v1::QueryResultResponse result = result_of(connection, job.id(), notes, frame_status);
  return report_page(job, result, judge_study_of(connection, job),
                     frames_of_page(connection, job.id(), result));
}

}  // namespace dccast::client::render
