#include <cmath>

#include "tests/verification/program/casting_run.hpp"
#include "tests/verification/program/paper_tables.hpp"
#include "tests/verification/program/run_request.hpp"

namespace dccast::verification {

namespace {

using mechanics::Algorithm;

/// The paper's parameters for sbm in its section 5.2.
mechanics::AlgorithmParameters sbm_of_the_paper() {
  mechanics::AlgorithmParameters parameters;
  parameters.gamma_c = 0.5e6;
  parameters.lambda_c = 1e-6;
  parameters.gamma_p = 1.25e-12;
  parameters.lambda_p = 0.4e12;
  return parameters;
}

mechanics::AlgorithmParameters with_contact_parameter(double gamma_c) {
  mechanics::AlgorithmParameters parameters;
  parameters.gamma_c = gamma_c;
  return parameters;
}

mechanics::AlgorithmParameters with_increment_test(mechanics::AlgorithmParameters parameters) {
  parameters.increment_test = true;
  return parameters;
}

struct CastingRow {
  const char* label;
  Algorithm algorithm;
  mechanics::AlgorithmParameters parameters{};
  Cell paper_seconds{}, paper_iterations{};
};

/// @return seconds used, whether or not the run reached its end
double add_casting(Table& table, const CastingRow& row, double limit) {
  casting::Case casting_case = shipped_casting(mesh::ElementKind::p1);
  casting_case.mechanics.options.algorithm = row.algorithm;
  casting_case.mechanics.options.parameters = row.parameters;
  const CastingRun run = run_casting(casting_case, limit);
  const auto curl = run.curl_mm();
  table.rows.push_back({row.label, row.paper_seconds, row.paper_iterations, run.seconds,
                        run.last.time, long(run.last.step), run.iterations_per_step(),
                        run.failed_attempts, curl ? Cell(*curl) : Cell(), run.ending()});
  if (!run.outcome.failures.empty()) {
    table.remarks.push_back(std::string(row.label) + ": " + run.outcome.failures.front().message);
  }
  return run.seconds;
}

}  // namespace

bool has_casting_table() {
  return true;
}

Table casting_table(const TableOptions& options) {
  Table table;
  table.title = "Table 11: start of a casting, all four algorithms";
  const casting::Case shown = shipped_casting(mesh::ElementKind::p1);
  table.setup =
      std::string("Case `") + casting_name +
      "`: thickness section, 1320 P1 triangles at the start, 0 to " +
      std::to_string(long(std::lround(shown.time.end))) +
      " s with the steps of the case. Heat, files and checks are in the seconds. The paper's "
      "slab and thermal data are not published: its curl is not ours to match.";
  table.columns = {"method",      "cpu paper [s]", "iterations paper",    "cpu [s]",
                   "reached [s]", "steps",         "iterations per step", "failed attempts",
                   "curl [mm]",   "how it ended"};
  const CastingRow rows[] = {{"newton", Algorithm::newton},
                             {"vnbm", Algorithm::vnbm, {}, 465.562, 89},
                             {"nbm", Algorithm::nbm},
                             {"sbm", Algorithm::sbm, sbm_of_the_paper(), 2660.49, 6593},
                             {"sbm, increment test", Algorithm::sbm,
                              with_increment_test(sbm_of_the_paper()), 2660.49, 6593},
                             {"sbm, gamma_c 5e8", Algorithm::sbm, with_contact_parameter(5e8)},
                             {"sbm, gamma_c 5e9", Algorithm::sbm, with_contact_parameter(5e9)}};
  double newton = 0.0;
  std::string ratios;
  for (const CastingRow& row : rows) {
    const double used = add_casting(table, row, options.limit);
    if (row.algorithm == Algorithm::newton) newton = used;
    if (row.algorithm != Algorithm::sbm) continue;
    char text[80];
    std::snprintf(text, sizeof text, "%s%s %.3g", ratios.empty() ? "" : "; ", row.label,
                  used / newton);
    ratios += text;
  }
  table.remarks.push_back("Seconds over those of newton, in this run (10 wanted): " + ratios + ".");
  table.remarks.push_back(
      "sbm has the parameters of the paper's section 5.2, gamma_c = 0.5e6 Pa/m, and is stopped by "
      "the "
      "residual of equilibrium and contact like the others; once by the paper's test of "
      "increments. "
      "gamma_c = 5e8 is the default of a case, 5e9 the best of the powers of ten for this slab.");
  table.remarks.push_back(
      "Curl is the vertical displacement of the first monitor of the case, `" +
      (shown.monitors.empty() ? std::string("none") : shown.monitors.front().name) + "`.");
  return table;
}

}  // namespace dccast::verification
