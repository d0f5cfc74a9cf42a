#include "client/render/report_page.hpp"

#include <algorithm>
#include <cmath>

#include "client/render/curl_history.hpp"
#include "client/render/findings.hpp"
#include "client/render/job_text.hpp"
#include "client/render/progress.hpp"
#include "client/render/report_style.hpp"
#include "client/render/section_picture.hpp"
#include "client/render/study_part.hpp"
#include "client/render/svg_chart.hpp"
#include "client/render/table.hpp"
#include "client/render/validity.hpp"
#include "proto/case_file/case_file.hpp"

namespace dccast::client::render {
namespace {

std::string element(const std::string& tag, const std::string& content) {
  return "<" + tag + ">" + content + "</" + tag.substr(0, tag.find(' ')) + ">";
}

std::string figure(const std::string& heading, const std::string& picture,
                   const std::string& caption) {
  return "<section class='card'><h2>" + heading + "</h2><figure>" + picture + "<figcaption>" +
         caption + "</figcaption></figure></section>";
}

std::string scientific(double value) {
  if (!std::isfinite(value)) return "-";
  if (value == 0.0) return "0";
  char text[32];
  std::snprintf(text, sizeof text, "%.2e", value);
  return text;
}

/// Values in millimetres of a series of metres.
std::vector<double> millimetres(std::vector<double> metres) {
  for (double& value : metres) value *= 1e3;
  return metres;
}

std::string curl_chart(const CurlHistory& history, const Study& study, bool against_length) {
  Chart chart;
  chart.title = against_length ? "Butt curl against cast length" : "Butt curl against time";
  chart.x_label = against_length ? "cast length, mm" : "time, s";
  chart.y_label = "curl, mm";
  const auto x = against_length ? millimetres(history.cast_length_m) : history.time_s;
  for (const auto& series : history.monitors)
    chart.lines.push_back({series.name, x, millimetres(series.curl_m),
                           curl_band(study, series.name, against_length)});
  if (const auto first = history.first_beyond()) {
    chart.beyond_from = x[*first];
    chart.beyond_name = beyond_validity;
  }
  return svg_chart(chart);
}

std::string tile(const std::string& name, const std::string& value, const std::string& unit,
                 const std::string& note = {}) {
  return "<div class='tile'><span>" + html_escaped(name) + "</span><strong>" + value +
         "</strong> " + unit + (note.empty() ? "" : "<small>" + note + "</small>") + "</div>";
}

/// The remark beside a figure of the last step; nothing while the model is valid.
std::string last_step_mark(const CurlHistory& history) {
  return !history.beyond.empty() && history.beyond.back() ? beyond_validity : "";
}

/// The curl at the end, with its error where a study tells it.
std::string curl_tile(const CurlHistory& history, const CurlHistory::Series& series,
                      const Study& study) {
  const double curl = series.curl_m.back();
  const std::string mark = last_step_mark(history);
  const auto error = curl_error(study, series.name, history.time_s.back(), curl);
  if (!error) return tile("curl, " + series.name, fixed(1e3 * curl, 2), "mm", mark);
  const std::string limit = std::string(error->extrapolated ? "limit " : "finest ") +
                            fixed(1e3 * error->limit_m, 2) + " ± " +
                            fixed(1e3 * error->uncertainty_m, 2);
  return tile("curl, " + series.name, fixed(1e3 * curl, 2), "mm",
              "<em>± " + fixed(1e3 * error->this_run_m, 2) + " mm</em>" + limit +
                  (mark.empty() ? "" : "<br>" + mark));
}

std::string headline(const CurlHistory& history, const v1::QueryResultResponse& result,
                     const Study& study) {
  if (history.time_s.empty()) return "<p>The job has no step yet.</p>";
  std::string tiles;
  for (const auto& series : history.monitors) tiles += curl_tile(history, series, study);
  const std::string mark = last_step_mark(history);
  const v1::StepReport& last = result.steps(result.steps_size() - 1);
  tiles += tile("cast length", fixed(1e3 * last.cast_length_m(), 1), "mm") +
           tile("time", fixed(last.time_s(), 1), "s") +
           tile("stands on the block", fixed(1e3 * last.contact_length_m(), 0), "mm", mark) +
           tile("sump depth", fixed(1e3 * last.sump_depth_m(), 0), "mm", mark);
  return "<div class='tiles'>" + tiles + "</div>";
}

/// The sentence at the top of a page whose figures are not all an answer.
std::string validity_banner(const v1::Job& job, const CurlHistory& history) {
  const auto first = history.first_beyond();
  if (!first && !job.has_validity_loss()) return {};
  const std::string said = job.has_validity_loss() ? validity_text(job.validity_loss())
                                                   : std::string(beyond_validity) + " from " +
                                                         fixed(history.time_s[*first], 2) + " s on";
  return "<p class='invalid'>This run is " + html_escaped(said) +
         ". Figures after that time are marked; they are not an answer.</p>";
}

/// "Beyond validity. " before the caption of a frame stored after the model stopped being valid.
std::string frame_mark(const v1::Frame& frame, const CurlHistory& history) {
  const auto first = history.first_beyond();
  const bool valid = !first || frame.time_s() < history.time_s[*first];
  return valid ? "" : "<strong>Beyond validity, not an answer.</strong> ";
}

std::string section_figure(const v1::QueryResultResponse& result, const CurlHistory& history) {
  const SectionPicture picture =
      result.has_frame() ? draw_section(result.frame()) : SectionPicture{};
  if (picture.svg.empty())
    return "<section class='card'><h2>Section</h2><p>No stored frame: the run has not ended with a "
           "result.</p></section>";
  const v1::Frame& frame = result.frame();
  return figure(
      "Deformed section and isotherms", picture.svg,
      frame_mark(frame, history) + "Half section at " + fixed(frame.time_s(), 1) +
          " s, cast length " + fixed(1e3 * frame.cast_length_m(), 1) +
          " mm. Displacements are drawn <strong>" + fixed(picture.displacement_scale, 0) +
          " times</strong> as large; dashed: undeformed. Isotherms every 100 °C; heavy: solidus " +
          fixed(frame.solidus_c(), 0) + " °C, heavy dashed: liquidus " +
          fixed(frame.liquidus_c(), 0) + " °C. The left edge is the symmetry plane.");
}

/// Position, gap and pressure of the bottom nodes that fit each other.
std::string contact_figures(const v1::Frame& frame, const CurlHistory& history) {
  ChartLine gap{"gap", {}, {}}, pressure{"pressure", {}, {}};
  for (int i = 0; i < frame.bottom_node_size(); ++i) {
    const int node = frame.bottom_node(i);
    if (node < 0 || 2 * node + 1 >= frame.node_m_size()) continue;
    const double x = 1e3 * frame.node_m(2 * node);
    if (i < frame.bottom_gap_m_size()) {
      gap.x.push_back(x);
      gap.y.push_back(1e3 * frame.bottom_gap_m(i));
    }
    if (i < frame.bottom_pressure_pa_size()) {
      pressure.x.push_back(x);
      pressure.y.push_back(1e-3 * frame.bottom_pressure_pa(i));
    }
  }
  if (gap.x.empty() && pressure.x.empty()) return {};
  const std::string mark = frame_mark(frame, history);
  const std::string place = "distance from the symmetry plane, mm";
  return "<div class='pair'>" +
         figure("Gap along the bottom",
                svg_chart({"Gap along the bottom", place, "gap, mm", {gap}}),
                mark + "Distance between slab and bottom block at the last frame.") +
         figure(
             "Contact pressure",
             svg_chart({"Contact pressure along the bottom", place, "pressure, kPa", {pressure}}),
             mark + "Zero where the slab has lifted off the block.") +
         "</div>";
}

std::string row(const std::string& name, const std::string& value, const std::string& note = {}) {
  return "<tr><th scope='row'>" + name + "</th><td>" + value + "</td><td>" + note + "</td></tr>";
}

double largest(const v1::QueryResultResponse& result, double (v1::StepReport::*figure_of)() const) {
  double value = 0.0;
  for (const v1::StepReport& step : result.steps())
    value = std::max(value, std::abs((step.*figure_of)()));
  return value;
}

std::string checks_table(const v1::QueryResultResponse& result, const CurlHistory& history) {
  if (result.steps_size() == 0) return {};
  const v1::StepReport& last = result.steps(result.steps_size() - 1);
  const std::string mark = last_step_mark(history);
  const std::string of_last_step = "last step" + (mark.empty() ? "" : ", " + mark);
  std::string rows;
  rows += row("Equilibrium residual",
              scientific(largest(result, &v1::StepReport::equilibrium_residual)),
              "largest of all steps, relative");
  rows += row("Energy balance", scientific(largest(result, &v1::StepReport::energy_balance_error)),
              "largest of all steps, relative");
  rows +=
      row("Complementarity", scientific(largest(result, &v1::StepReport::complementarity_error)),
          "gap times pressure, relative");
  rows += row("Constitutive residual",
              scientific(largest(result, &v1::StepReport::constitutive_residual)), "relative");
  rows += row("Pressure on the liquidus front", scientific(last.liquid_pressure_error()),
              "against the metallostatic one, relative, " + of_last_step);
  rows += row("Bottom reaction", fixed(last.bottom_reaction_n_per_m(), 1) + " N/m",
              "weight " + fixed(last.weight_n_per_m(), 1) + " N/m, " + of_last_step);
  rows +=
      row("Heat through side and bottom", fixed(1e-3 * last.wall_heat_flux_w_per_m(), 1) + " kW/m",
          "per metre of face, " + of_last_step);
  return "<section class='card'><h2>Checks of the run</h2><table>" + rows + "</table></section>";
}

std::string run_table(const v1::Job& job, const v1::QueryResultResponse& result) {
  std::string rows = row("State", full_state_text(job)) + row("Job", html_escaped(job.id())) +
                     row("Study", job.study().empty() ? "none" : html_escaped(job.study())) +
                     row("Ended", time_text(job.end_time())) +
                     row("Case SHA-256", "<code>" + html_escaped(job.case_sha256()) + "</code>");
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
  return "<section class='card'><h2>Run</h2><table>" + rows + "</table></section>";
}

std::string element_row(v1::ElementKind element) {
  switch (element) {
    case v1::P1:
      return row("Element", "p1",
                 "linear triangles lock on coarse meshes: compare with q1_bending");
    case v1::Q1:
      return row("Element", "q1", "long cells resist bending: compare with q1_bending");
    default:
      return row("Element", "q1_bending");
  }
}

std::string coherency_text(const v1::Alloy& alloy) {
  if (alloy.has_coherency_solid_fraction())
    return "solid fraction " + fixed(alloy.coherency_solid_fraction(), 2);
  return fixed(alloy.has_coherency_c() ? alloy.coherency_c() : alloy.liquidus_c(), 0) + " °C";
}

std::string inputs_table(const v1::Case& input) {
  const v1::Alloy& alloy = input.alloy();
  std::string rows;
  rows += row("Hold before the block moves", fixed(input.schedule().hold_s(), 1) + " s",
              "the shell forms; t = 0 is when the block starts");
  rows += row("Mechanics starts", fixed(input.mechanics().start_s(), 1) + " s",
              "from a stress-free shell: what happened before leaves no curl");
  rows += row("Coherency", coherency_text(alloy),
              "below it the mush transmits stress; solidus " + fixed(alloy.solidus_c(), 0) +
                  ", liquidus " + fixed(alloy.liquidus_c(), 0) + " °C");
  rows +=
      row("Alloy card", html_escaped(alloy.card()) + " (" + html_escaped(alloy.provenance()) + ")",
          html_escaped(alloy.description()));
  rows += row("Half width", fixed(1e3 * input.section().half_width_m(), 0) + " mm");
  rows += element_row(input.mesh().element());
  rows +=
      row("Algorithm", html_escaped(v1::Mechanics::Algorithm_Name(input.mechanics().algorithm())));
  return "<section class='card'><h2>What the result rests on</h2><table>" + rows +
         "</table><details><summary>The whole case, with all defaults</summary><pre>" +
         html_escaped(case_file::to_toml(input)) + "</pre></details></section>";
}

}  // namespace

std::string report_page(const v1::Job& job, const v1::QueryResultResponse& result,
                        const Study& study) {
  const CurlHistory history = curl_history(job, result);
  const std::string title = html_escaped(job.title().empty() ? "Casting " + job.id() : job.title());
  std::string body = "<header><p class='kicker'>dccast report · job " +
                     html_escaped(job.id().substr(0, 8)) + " · <span class='state " +
                     state_text(job.state()) + "'>" + state_text(job.state()) + "</span></p>" +
                     element("h1", title) + "</header>";
  body += findings_part(job.findings()) + validity_banner(job, history) +
          headline(history, result, study);
  const std::string of_the_band =
      study.monitors.empty() ? "" : " Dashed: the limit of finer meshes; shaded: its uncertainty.";
  const std::string of_the_region =
      history.first_beyond() ? " Shaded red: beyond validity, not an answer." : "";
  if (!history.monitors.empty())
    body +=
        "<div class='pair'>" +
        figure("Curl against time", curl_chart(history, study, false),
               "Upward displacement of each monitor; time zero is when the bottom block starts." +
                   of_the_band + of_the_region) +
        figure("Curl against cast length", curl_chart(history, study, true),
               "The same against the travel of the bottom block." + of_the_region) +
        "</div>" + study_part(study, job);
  body += section_figure(result, history);
  if (result.has_frame()) body += contact_figures(result.frame(), history);
  body += "<div class='pair'>" + checks_table(result, history) + run_table(job, result) + "</div>";
  if (result.has_case_()) body += inputs_table(result.case_());
  return "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
         "content='width=device-width, initial-scale=1'><title>" +
         title + "</title><style>" + report_style + "</style></head><body><main>" + body +
         "</main></body></html>\n";
}

}  // namespace dccast::client::render
