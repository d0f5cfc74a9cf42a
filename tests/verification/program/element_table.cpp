#include <cmath>

#include "proto/values/interpolation.hpp"
#include "server/studies/extrapolation.hpp"
#include "tests/verification/program/casting_run.hpp"
#include "tests/verification/program/paper_tables.hpp"

namespace dccast::verification {

namespace {

/// The runs of one element under refinement.
struct Family {
  const char* name;
  mesh::ElementKind element;
  std::vector<double> time_s{};
  std::vector<studies::RefinedCurve> curves{};  ///< coarsest first
  std::vector<double> seconds{};                ///< by curve

  double last_mm(std::size_t level) const { return 1e3 * curves[level].value_m.back(); }
  studies::CurveLimit limit() const { return studies::extrapolate(time_s, curves); }
};

std::string format(const char* format, double a, double b) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

/// Runs the case with every cell divided, and adds a row without its error.
void add_level(Table& table, Family& family, int refinement, double limit) {
  casting::Case casting_case = shipped_casting(family.element);
  casting_case.section.refinement = refinement;
  const CastingRun run = run_casting(casting_case, limit);
  const auto curl = run.curl_mm();
  table.rows.push_back({family.name, refinement, run.last.nodes, run.seconds,
                        curl ? Cell(*curl) : Cell(), Cell(), run.ending()});
  if (run.outcome.end != casting::RunEnd::succeeded) return;

  if (family.time_s.empty()) family.time_s = run.time_s;
  family.seconds.push_back(run.seconds);
  family.curves.push_back({refinement, values::at_instants(family.time_s, run.time_s, run.curl_m)});
}

/// Seconds that a family needs for an error, interpolated in logarithms between its two nearest
/// levels.
double seconds_for(const Family& family, double limit_mm, double error_mm) {
  const auto log_error = [&](std::size_t i) {
    return std::log(std::abs(limit_mm - family.last_mm(i)));
  };
  std::size_t i = 1;
  while (i + 1 < family.seconds.size() && log_error(i) > std::log(error_mm)) ++i;
  const double share = (std::log(error_mm) - log_error(i - 1)) / (log_error(i) - log_error(i - 1));
  return family.seconds[i - 1] * std::pow(family.seconds[i] / family.seconds[i - 1], share);
}

/// The limit of the final curl of a family [mm].
struct Limit {
  double value, uncertainty;
  std::string text;
};

Limit find_limit(const Family& family) {
  const studies::CurveLimit curve = family.limit();
  const Limit limit{1e3 * curve.value_m.back(), 1e3 * curve.uncertainty_m.back(), {}};
  std::string text = format("%.3f +- %.3f mm", limit.value, limit.uncertainty);
  if (curve.order) text += format(" (order %.2f)", *curve.order, 0.0);
  return {limit.value, limit.uncertainty, text};
}

}  // namespace

ElementComparison compare_elements(const TableOptions& options) {
  ElementComparison comparison;
  Table& table = comparison.table;
  table.title = "Elements: error of the curl, and what it costs";
  table.setup =
      std::string("Case `") + casting_name +
      "`, newton, every cell divided, the time steps of the case. `error` is against the limit "
      "to which q1_bending tends. Seconds are processor time of the whole run.";
  table.columns = {"element",   "refinement", "nodes at the end", "cpu [s]",
                   "curl [mm]", "error [%]",  "how it ended"};
  Family families[] = {{"p1", mesh::ElementKind::p1},
                       {"q1", mesh::ElementKind::q1},
                       {"q1_bending", mesh::ElementKind::q1_bending}};

  for (Family& family : families) {
    for (const int refinement : {1, 2, 4}) add_level(table, family, refinement, options.limit);
    if (family.curves.size() < 3) return comparison;
  }

  const Family& best = families[2];
  const Limit limit = find_limit(best);
  for (auto& row : table.rows) {
    if (row[4].is_number()) row[5] = 100.0 * (row[4].get<double>() - limit.value) / limit.value;
  }

  // All elements must tend to the same curl.
  std::string limits = "Limits:";
  comparison.same_limit = true;
  for (const Family& family : families) {
    const Limit own = find_limit(family);
    limits += (&family == families ? " " : ", ") + std::string(family.name) + " " + own.text;
    comparison.same_limit = comparison.same_limit && std::abs(own.value - limit.value) <=
                                                         own.uncertainty + limit.uncertainty;
  }
  table.remarks.push_back(
      limits + ": " +
      (comparison.same_limit ? "one curl, within the uncertainties." : "NOT one curl."));

  const double error = std::abs(limit.value - best.last_mm(0));
  table.remarks.push_back(
      format("The error q1_bending has after %.3g s takes q1 %.3g s", best.seconds.front(),
             seconds_for(families[1], limit.value, error)) +
      format(" and p1 %.3g s (between their levels, in logarithms): q1_bending is the default.",
             seconds_for(families[0], limit.value, error), 0.0));
  return comparison;
}

}  // namespace dccast::verification
