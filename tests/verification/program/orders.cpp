#include "tests/verification/program/orders.hpp"

#include <cmath>
#include <stdexcept>

#include "tests/verification/mechanics/exact_checks.hpp"
#include "tests/verification/program/named_tests.hpp"

namespace dccast::verification {

namespace {

double order(double coarse, double fine) {
  return std::log2(coarse / fine);
}

const Figures& succeeded(const Result& result) {
  if (const auto* failed = std::get_if<Failed>(&result)) throw std::runtime_error(failed->why);
  return std::get<Figures>(result);
}

/// Order of the error `of` in steps dt and dt / 2.
template <class Run>
double order_in_time(Run&& run, double dt, double Figures::*of) {
  TestRun coarse, fine;
  coarse.dt = dt, fine.dt = 0.5 * dt;
  return order(succeeded(run(coarse)).*of, succeeded(run(fine)).*of);
}

/// A test by every algorithm: newton's figures, the iterations of each and the largest relative
/// difference of their displacements to newton's.
Result by_every_algorithm(Result (*test)(const TestRun&), TestRun run) {
  Figures figures;
  for (const auto algorithm : {mechanics::Algorithm::newton, mechanics::Algorithm::vnbm,
                               mechanics::Algorithm::sbm, mechanics::Algorithm::nbm}) {
    run.options.algorithm = algorithm;
    const Result result = test(run);
    if (const auto* failed = std::get_if<Failed>(&result)) {
      return Failed{failed->time, name_of(algorithm) + ": " + failed->why};
    }
    const Figures& ours = std::get<Figures>(result);
    if (figures.displacement.empty()) {
      figures = ours;
      figures.more.clear();
    }
    figures.more["iterations_per_step_" + name_of(algorithm)] = ours.iterations_per_step;
    double difference = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < ours.displacement.size(); ++i) {
      difference += std::pow(ours.displacement[i] - figures.displacement[i], 2);
      scale += figures.displacement[i] * figures.displacement[i];
    }
    double& largest = figures.more["largest_difference"];
    largest = std::max(largest, std::sqrt(difference / scale));
  }
  return figures;
}

}  // namespace

std::vector<Refinement> refine_t1(mesh::ElementKind element) {
  std::vector<Refinement> errors;
  for (int factor : {1, 2, 4, 8}) {
    T1Run run;
    run.columns = 20 * factor;
    run.rows = 24 * factor;
    run.element = element;
    const T1Result t1 = run_t1(run);
    errors.push_back({0.5 / run.columns, t1.whole.displacement, t1.whole.stress});
  }
  return errors;
}

std::vector<Refinement> refine_t4() {
  std::vector<Refinement> errors;
  for (double dt : {0.0625, 0.03125, 0.015625, 0.0078125, 0.00390625}) {
    TestRun run;
    run.dt = dt;
    const Result result = run_t4(run);
    const Figures& figures = succeeded(result);
    errors.push_back({dt, figures.displacement_error, figures.stress_error});
  }
  return errors;
}

Result run_orders(const RunRequest& request) {
  const double start = cpu_seconds();
  Figures figures;
  const auto t1 = refine_t1(request.element);
  const Refinement &coarse = t1[t1.size() - 2], &fine = t1.back();
  figures.displacement_error = fine.displacement;
  figures.stress_error = fine.stress;
  figures.more["order_t1_displacement"] = order(coarse.displacement, fine.displacement);
  figures.more["order_t1_stress"] = order(coarse.stress, fine.stress);
  figures.more["order_t4_displacement"] =
      order_in_time(run_t4, 0.0078125, &Figures::displacement_error);
  figures.more["order_t4_stress"] = order_in_time(run_t4, 0.0078125, &Figures::stress_error);
  figures.more["order_relaxation_stress"] =
      order_in_time(run_relaxation, 0.0125, &Figures::stress_error);
  figures.cpu_s = cpu_seconds() - start;
  return figures;
}

Result run_hertz_orders(const RunRequest& request) {
  constexpr int coarsest = 16, halvings = 3;
  TestRun run;
  run.options = options_of(request);
  run.element = request.element;
  const double start = cpu_seconds();
  std::vector<Figures> found;
  for (int i = 0; i <= halvings; ++i) {
    run.cells = coarsest << i;
    const Result result = run_hertz(run);
    if (std::holds_alternative<Failed>(result)) return result;
    found.push_back(std::get<Figures>(result));
  }
  const Figures &coarse = found.front(), &fine = found.back();
  Figures figures = fine;
  for (std::size_t i = 0; i < found.size(); ++i) {
    figures.more["pressure_error_" + std::to_string(coarsest << i) + "_cells"] =
        found[i].more.at("pressure_error");
    // Each mesh meets the edge elsewhere in a cell: the worst of them counts.
    double& edge = figures.more["half_width_error_in_cells"];
    edge = std::max(edge, found[i].more.at("half_width_error_in_cells"));
  }
  figures.more["order_stress"] = order(coarse.stress_error, fine.stress_error) / halvings;
  figures.more["order_pressure"] =
      order(coarse.more.at("pressure_error"), fine.more.at("pressure_error")) / halvings;
  figures.cpu_s = cpu_seconds() - start;
  return figures;
}

Result run_agreement(const RunRequest& request) {
  const double start = cpu_seconds();
  TestRun run;
  run.dt = request.dt.value_or(0.0625);
  run.options.tolerance = request.tolerance.value_or(1e-10);
  run.options.parameters.gamma_p = 1e-6;
  run.options.parameters.gamma_c = 0.5e12;
  Result result = by_every_algorithm(run_t4, run);
  if (std::holds_alternative<Failed>(result)) return result;
  run.options.parameters.gamma_c = hertz_gamma_c;
  run.cells = 32;
  run.element = mesh::ElementKind::q1;
  const Result hertz = by_every_algorithm(run_hertz, run);
  if (std::holds_alternative<Failed>(hertz)) return hertz;
  Figures& figures = std::get<Figures>(result);
  for (const auto& [key, value] : std::get<Figures>(hertz).more) {
    figures.more[key + "_hertz"] = value;
  }
  figures.cpu_s = cpu_seconds() - start;
  return result;
}

}  // namespace dccast::verification
