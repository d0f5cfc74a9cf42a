#include "tests/verification/program/named_tests.hpp"
#include "tests/support/usual_options.hpp"

#include <stdexcept>

#include "tests/verification/mechanics/exact_checks.hpp"
#include "tests/verification/program/heat_tests.hpp"
#include "tests/verification/program/orders.hpp"

namespace dccast::verification {

mechanics::Options options_of(const RunRequest& request) {
  mechanics::Options options = testing::usual_options(request.tolerance.value_or(1e-8));
  options.algorithm = request.algorithm;
  auto& p = options.parameters;
  p.plain = request.plain;
  p.increment_test = request.increment_test;
  if (request.algorithm != mechanics::Algorithm::sbm) return options;

  // Parameters of the paper for its tests.
  p.gamma_p = 1e-6;
  p.lambda_p = 0.5e6;
  if (request.name.starts_with("hertz")) {
    p.gamma_c = hertz_gamma_c;
    return options;
  }

  const bool is_t2 = request.name == "T2";
  p.gamma_c = is_t2 ? 0.5e9 : 0.5e12;
  p.lambda_c = is_t2 ? 1e-9 : 1e-12;
  return options;
}

namespace {

TestRun test_run(const RunRequest& request, double usual_dt) {
  TestRun run;
  run.options = options_of(request);
  run.dt = request.dt.value_or(usual_dt);
  run.cells = request.cells;
  run.element = request.element;
  run.end = request.end;
  if (request.cut_steps) run.cut_steps = true;
  return run;
}

Result run_t1_by_name(const RunRequest& request) {
  T1Run run;
  if (request.cells > 0) {  // columns; rows in the proportion of the usual mesh, by sixes
    run.columns = request.cells;
    run.rows = run.liquid_rows = (request.cells * 48 / 40 + 5) / 6 * 6;
  }
  run.element = request.element;
  run.diagonals = request.diagonals;
  run.liquid = request.liquid;
  const T1Result t1 = run_t1(run);

  Figures figures;
  figures.displacement_error = t1.whole.displacement;
  figures.stress_error = t1.whole.stress;
  figures.iterations_per_step = 1.0;
  figures.cpu_s = t1.cpu_s;
  figures.elements = t1.solid_elements;
  figures.nodes = t1.nodes;
  figures.steps = 1;

  figures.more = {{"displacement_error_max_norm", t1.whole.displacement_max},
                  {"stress_error_max_norm", t1.whole.stress_max},
                  {"away_displacement_error", t1.away.displacement},
                  {"away_displacement_error_max_norm", t1.away.displacement_max},
                  {"away_stress_error", t1.away.stress},
                  {"away_stress_error_max_norm", t1.away.stress_max}};

  // With a fictitious liquid also the errors relative to those of the pressure given directly.
  if (run.liquid) {
    figures.more["front_pressure_error"] = t1.pressure_on_front_error;
    run.liquid.reset();
    const T1Result direct = run_t1(run);
    figures.more["displacement_error_over_direct"] =
        t1.whole.displacement / direct.whole.displacement;
    figures.more["stress_error_over_direct"] = t1.whole.stress / direct.whole.stress;
  }
  return figures;
}

using Mechanical = Result (*)(const TestRun&);
std::function<Result(const RunRequest&)> mechanical(Mechanical run, double usual_dt) {
  return [run, usual_dt](const RunRequest& request) { return run(test_run(request, usual_dt)); };
}

}  // namespace

const std::vector<NamedTest>& named_tests() {
  static const std::vector<NamedTest> tests{
      {"T1", "paper 3.4.1: metallostatic pressure, given or by a fictitious liquid", "0.02 s",
       run_t1_by_name},
      {"T2", "paper 4.3.1: thermo-elastic contact with a moving gap", "9 s at dt 1, 90 s at 0.1",
       mechanical(run_t2, 1.0)},
      {"T3", "paper 4.3.2: elastic-viscoplastic square, stress linear in time",
       "0.01 s at dt 0.0625, 1 min at 1e-5", mechanical(run_t3, 0.0625)},
      {"T4", "paper 4.3.4: T3 with Signorini contact", "0.01 s at dt 0.0625, 1 min at 1e-5",
       mechanical(run_t4, 0.0625)},
      {"patch", "linear displacement and rotation on a distorted mesh leave round-off", "0.01 s",
       mechanical(run_patch, 1.0)},
      {"creep", "constant load creeps at a constant rate, exactly", "0.02 s",
       mechanical(run_creep, 0.0625)},
      {"relaxation", "a held strain relaxes by its closed form, first order in dt", "0.01 s",
       mechanical(run_relaxation, 0.0125)},
      {"bowed-strip", "a free strip bows under a linear temperature without stress in its plane",
       "0.01 s", mechanical(run_bowed_strip, 1.0)},
      {"plate", "long cells bend: end moments on a plate against beam theory", "0.01 s",
       mechanical(run_plate, 1.0)},
      {"modes", "a cell deforms without energy as a rigid body only", "0.01 s",
       mechanical(run_modes, 1.0)},
      {"ring-patch", "uniform strain of an axisymmetric body on a distorted mesh leaves round-off",
       "0.01 s", mechanical(run_axisymmetric_patch, 1.0)},
      {"tube", "thick-walled tube under inner pressure against Lame, also nearly incompressible",
       "0.01 s", mechanical(run_tube, 1.0)},
      {"tube-creep", "the same tube creeping steadily by Norton's law", "0.1 s",
       mechanical(run_tube_creep, 2.0)},
      {"hertz", "a block on a rigid cylinder, against Hertz's half width and pressure", "0.5 s",
       mechanical(run_hertz, 1.0)},
      {"hertz-cycle", "the same pressed and released: the contact opens as it closed", "1 s",
       mechanical(run_hertz_cycle, 1.0)},
      {"hertz-orders", "Hertz's contact by cells halved three times", "5 s",
       [](const RunRequest& request) { return run_hertz_orders(request); }},
      {"orders", "observed orders under refinement: T1 in the cell, T4 in the step", "0.5 s",
       [](const RunRequest& request) { return run_orders(request); }},
      {"agreement", "largest difference of the four algorithms, T4 and Hertz, tight tolerance",
       "5 s", [](const RunRequest& request) { return run_agreement(request); }},
      {"stefan", "two-phase Stefan problem, isothermal change, against Neumann", "0.5 s",
       run_stefan_by_name},
      {"mushy-stefan", "Stefan problem over a solidification interval", "0.5 s",
       run_mushy_stefan_by_name},
      {"strand", "steady moving strand against its closed form; --data FILE for another strand",
       "5 s", run_strand_by_name},
      {"decaying-mode", "cosine mode of an insulated square", "0.1 s", run_decaying_mode_by_name},
  };
  return tests;
}

RunRequest completed(RunRequest request) {
  if (request.dt) return request;
  if (request.name == "T2") request.dt = 1.0;
  if (request.name == "T3" || request.name == "T4") request.dt = 0.0625;
  return request;
}

Result run_by_name(const RunRequest& request) {
  for (const NamedTest& test : named_tests()) {
    if (test.name == request.name) return test.run(request);
  }
  throw std::invalid_argument("no test is called '" + request.name +
                              "'; `dccast-verify list` names them");
}

}  // namespace dccast::verification
