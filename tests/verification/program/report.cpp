#include "tests/verification/program/report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/verification/program/claims.hpp"
#include "tests/verification/program/discussion.hpp"
#include "tests/verification/program/orders.hpp"
#include "tests/verification/program/paper_tables.hpp"
#include "tests/verification/program/plot.hpp"

namespace dccast::verification {

namespace {

const char* style = R"(
body{font:15px/1.5 Helvetica,Arial,sans-serif;color:#24292f;margin:0;background:#f5f6f8}
header{background:#16324f;color:#fff;padding:28px 40px}
header h1{margin:0 0 6px;font-size:26px}header p{margin:0;max-width:900px;color:#d5dee8}
main{max-width:1280px;margin:0 auto;padding:16px 40px 60px}
section{background:#fff;border:1px solid #e1e4e8;border-radius:6px;padding:14px 22px 18px;margin:18px 0}
h2{font-size:18px;margin:4px 0 8px;color:#16324f}
.setup,.remarks{color:#57606a;font-size:13.5px;max-width:1000px}
.wide{overflow-x:auto}
table{border-collapse:collapse;font-size:13px;width:100%}
th,td{padding:5px 9px;border-bottom:1px solid #eaecef;text-align:left;vertical-align:top}
th{border-bottom:2px solid #c8ced5;font-weight:600;color:#3b4650}
td.number,th.number{text-align:right;font-variant-numeric:tabular-nums}
.pass{color:#1a7f37;font-weight:600}.miss{color:#cf222e;font-weight:700}
code{font-size:12px;background:#f0f2f4;padding:1px 4px;border-radius:3px}
.plots{display:flex;flex-wrap:wrap;gap:18px}
.count{font-size:32px;font-weight:700}.count small{font-size:15px;font-weight:400;color:#57606a}
)";

using Error = double Refinement::*;

Curve2D curve_of(const char* name, const std::vector<Refinement>& from, Error error) {
  Curve2D curve{name, {}, 0.0};
  for (const Refinement& r : from) curve.points.emplace_back(r.size, r.*error);
  return curve;
}

/// A line of the given order a little below a curve.
Curve2D reference(const char* name, const Curve2D& curve, double slope) {
  const auto [x0, y0] = curve.points.front();
  const double x1 = curve.points.back().first;
  return {name, {{x0, 0.6 * y0}, {x1, 0.6 * y0 * std::pow(x1 / x0, slope)}}, slope};
}

std::string t1_plot(mesh::ElementKind element, const char* title) {
  const auto errors = refine_t1(element);
  const Curve2D u = curve_of("displacement", errors, &Refinement::displacement);
  const Curve2D s = curve_of("stress", errors, &Refinement::stress);
  return log_log_svg(title, "cell [m]",
                     {u, s, reference("order 2", u, 2.0), reference("order 1", s, 1.0)});
}

std::string t4_plot() {
  const auto errors = refine_t4();
  const Curve2D u = curve_of("displacement", errors, &Refinement::displacement);
  return log_log_svg(
      "T4: relative L2 error against the step", "time step [s]",
      {u, curve_of("stress", errors, &Refinement::stress), reference("order 1", u, 1.0)});
}

std::string plots() {
  return "<section><h2>Convergence</h2><div class=\"plots\">" +
         t1_plot(mesh::ElementKind::p1, "T1 direct, P1: relative L2 error") +
         t1_plot(mesh::ElementKind::q1, "T1 direct, Q1: relative L2 error") + t4_plot() +
         "</div></section>\n";
}

std::string shear_section() {
  std::string out =
      "<section><h2>Shear stresses of T1 with a fictitious liquid (the paper's figures 9 to "
      "11)</h2><p class=\"setup\">sigma_23 at epsilon = 1e-3; the mean of the two triangles of "
      "each cell; the exact solution has none. Mind "
      "the scales: each picture has its own.</p><div class=\"plots\">";
  for (const auto& [delta, beta] : {std::pair{1.0, 2.0}, {1.0, 1.0}, {2.0, 1.0}}) {
    out += shear_picture({1e-3, delta, beta});
  }
  return out + "</div></section>\n";
}

std::string claims_section(bool nightly) {
  Runs runs;
  std::vector<Verdict> verdicts;
  for (const Claim& claim : claims()) {
    if (!claim.nightly || nightly) verdicts.push_back(judge(claim, runs));
  }
  const auto passed =
      std::count_if(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.passed; });
  char count[160];
  std::snprintf(
      count, sizeof count,
      "<section><div class=\"count\">%ld of %zu <small>figures reached</small></div></section>\n",
      long(passed), verdicts.size());
  return count + to_html(table_of(verdicts));
}

}  // namespace

std::string shear_picture(const FictitiousLiquid& liquid) {
  T1Run run;
  run.liquid = liquid;
  const T1Result t1 = run_t1(run);
  // Mean of the two triangles of a cell: their alternation is the element's, not the method's.
  std::vector<double> shear = t1.shear_stress;
  for (std::size_t i = 0; i + 1 < shear.size(); i += 2) {
    shear[i] = shear[i + 1] = 0.5 * (shear[i] + shear[i + 1]);
  }
  double strongest = 0.0;
  for (double s : shear) strongest = std::max(strongest, std::abs(s));
  const double digit = std::pow(10.0, std::floor(std::log10(strongest)));
  char title[80];
  std::snprintf(title, sizeof title, "delta = %g, beta = %g, epsilon = %g", liquid.delta,
                liquid.beta, liquid.epsilon);
  return field_svg(title, t1.mesh, shear, digit * std::ceil(strongest / digit), "sigma_23 [Pa]");
}

std::string html_report(const ReportOptions& options) {
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<title>dccast: verification</title><style>";
  out += style;
  out +=
      "</style></head><body><header><h1>dccast: verification</h1><p>The tests and tables of the "
      "paper, and exact solutions, held against the core. Every figure on this page was computed "
      "by the program that wrote it; the command beside a figure repeats it.</p></header><main>\n";
  const TableOptions table_options{options.nightly, options.limit};
  out += claims_section(options.nightly);
  out += contents_section() + differences_section();
  out += plots();
  out += shear_section() + deformed_square_section();
  for (int number : {1, 2, 3, 4, 5, 6, 7, 8, 11}) {
    if (number == 11 && (options.no_casting || !has_casting_table())) continue;
    out += to_html(*paper_table(number, table_options));
  }
  if (!options.no_casting && has_casting_table()) out += casting_figures(table_options);
  if (options.nightly && !options.no_casting && has_casting_table()) {
    out += to_html(compare_elements(table_options).table);
  }
  return out + "</main></body></html>\n";
}

}  // namespace dccast::verification
