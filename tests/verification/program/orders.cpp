#include "tests/verification/program/orders.hpp"

#include <cmath>
#include <stdexcept>

#include "tests/verification/mechanics/exact_checks.hpp"

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

Result run_agreement(const RunRequest& request) {
  constexpr double tight = 1e-10;
  const double start = cpu_seconds();
  Figures figures;
  std::vector<double> reference;
  for (const auto algorithm : {mechanics::Algorithm::newton, mechanics::Algorithm::vnbm,
                               mechanics::Algorithm::sbm, mechanics::Algorithm::nbm}) {
    TestRun run;
    run.dt = request.dt.value_or(0.0625);
    run.options.algorithm = algorithm;
    run.options.tolerance = request.tolerance.value_or(tight);
    run.options.parameters.gamma_p = 1e-6;
    run.options.parameters.gamma_c = 0.5e12;
    const Result result = run_t4(run);
    if (const auto* failed = std::get_if<Failed>(&result)) {
      return Failed{failed->time, name_of(algorithm) + ": " + failed->why};
    }
    const Figures& ours = std::get<Figures>(result);
    figures.more["iterations_per_step_" + name_of(algorithm)] = ours.iterations_per_step;
    if (reference.empty()) {
      reference = ours.displacement;
      figures.displacement_error = ours.displacement_error;
      figures.stress_error = ours.stress_error;
      figures.elements = ours.elements, figures.nodes = ours.nodes, figures.steps = ours.steps;
      figures.iterations_per_step = ours.iterations_per_step;
      continue;
    }
    double difference = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < reference.size(); ++i) {
      difference += std::pow(ours.displacement[i] - reference[i], 2);
      scale += reference[i] * reference[i];
    }
    auto& largest = figures.more["largest_difference"];
    largest = std::max(largest, std::sqrt(difference / scale));
  }
  figures.cpu_s = cpu_seconds() - start;
  return figures;
}

}  // namespace dccast::verification
