#include "client/html/run_part.hpp"

#include <algorithm>
#include <cmath>

#include "client/html/curl_part.hpp"
#include "client/html/html_parts.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/job_text.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

std::string scientific(double value) {
  if (!std::isfinite(value)) return "-";
  if (value == 0.0) return "0";
  char text[32];
  std::snprintf(text, sizeof text, "%.2e", value);
  return text;
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
  const bool quarter = result.case_().section().kind() == v1::Section::QUARTER_SLAB;
  const std::string per_metre = quarter ? "" : "/m";
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
  // Of the two fields of each figure a step has only one.
  const double reaction = last.bottom_reaction_n_per_m() + last.bottom_reaction_n();
  const double weight = last.weight_n_per_m() + last.weight_n();
  const double heat = last.wall_heat_flux_w_per_m() + last.wall_heat_flux_w();
  rows += row("Bottom reaction", fixed(reaction, 1) + " N" + per_metre,
              "weight " + fixed(weight, 1) + " N" + per_metre + ", " + of_last_step);
  rows += row("Heat through side and bottom", fixed(1e-3 * heat, 1) + " kW" + per_metre,
              (quarter ? "of the quarter, " : "per metre of face, ") + of_last_step);
  return card("Checks of the run", "<table>" + rows + "</table>");
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
  return card("Run", "<table>" + rows + "</table>");
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
  return card("What the result rests on",
              "<table>" + rows +
                  "</table><details><summary>The whole case, with all defaults</summary><pre>" +
                  html_escaped(readable_toml(input)) + "</pre></details>");
}

}  // namespace

std::string run_part(const v1::Job& job, const v1::QueryResultResponse& result,
                     const CurlHistory& history) {
  return checks_table(result, history) + run_table(job, result) +
         (result.has_case_() ? inputs_table(result.case_()) : "");
}

}  // namespace dccast::client::render
