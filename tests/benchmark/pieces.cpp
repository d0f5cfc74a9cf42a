// Seconds of the pieces of a step on a square of 1.3k, 20k and 80k triangles: what a Newton
// iteration and a heat step are made of, and how each grows.

#include <benchmark/benchmark.h>

#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/constrained_system.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/step_constraints.hpp"
#include "core/thermal/heat_solver.hpp"
#include "tests/support/load_case.hpp"
#include "tests/verification/mechanics/fixed_body.hpp"

namespace {

using namespace dccast;
using Element = fem::P1Triangle;
using Body = verification::FixedBody<Element>;

/// Cells a side for about 1,300, 20,000 and 80,000 triangles.
void sizes(benchmark::internal::Benchmark* b) {
  for (int cells : {26, 100, 200}) b->Arg(cells);
  b->Unit(benchmark::kMillisecond);
}

/// A creeping body under a stretch that varies in space, so that every point creeps differently.
struct Scene {
  explicit Scene(int cells)
      : body(verification::uniform_rectangle(0.5, 0.5, cells, cells, mesh::ElementKind::p1)) {
    body.set_material(5e10, 0.4, 1e-40, 6.0);
    body.set_contact();
    body.problem.dt = 1.0;
    body.problem.weight = 1e3;
    for (int n : mesh::patch_nodes(body.mesh, mesh::PatchKind::symmetry)) body.fix(n, 0, 0.0);
    for (int n = 0; n < body.mesh.nodes(); ++n) {
      const double x = body.mesh.point(n)[0], y = body.mesh.point(n)[1];
      u.push_back(1e-3 * x * (1.0 + y));
      u.push_back(-5e-4 * y * (1.0 + x));
    }
  }
  Body body;
  std::vector<double> u;
};

void residual(benchmark::State& state) {
  Scene scene(static_cast<int>(state.range(0)));
  mechanics::Equilibrium equilibrium(scene.body.problem);
  for (auto _ : state) {
    benchmark::DoNotOptimize(equilibrium.residual(scene.u, scene.body.work.residual,
                                                  mechanics::return_map_law(scene.body.problem)));
  }
  state.counters["triangles"] = scene.body.mesh.elements();
}
BENCHMARK(residual)->Apply(sizes);

void assembly(benchmark::State& state) {
  Scene scene(static_cast<int>(state.range(0)));
  mechanics::Equilibrium equilibrium(scene.body.problem);
  equilibrium.residual(scene.u, scene.body.work.residual,
                       mechanics::return_map_law(scene.body.problem));
  for (auto _ : state) equilibrium.tangent(scene.body.work.stiffness);
}
BENCHMARK(assembly)->Apply(sizes);

/// Stiffness with its supports, ready to be factorised.
struct Linear : Scene {
  explicit Linear(int cells) : Scene(cells) {
    mechanics::Equilibrium equilibrium(body.problem);
    equilibrium.residual(u, body.work.residual, mechanics::return_map_law(body.problem));
    equilibrium.tangent(body.work.stiffness);
    mechanics::ConstrainedSystem system(body.pattern, body.work);
    std::vector<char> closed(body.problem.contact.size(), 1);
    mechanics::StepConstraints<2> constraints(body.problem, closed,
                                              mechanics::round_off_force(body.problem));
    const std::vector<double> none(u.size(), 0.0);
    benchmark::DoNotOptimize(system.factorize(constraints.fixed(), none));
  }
};

void analysis(benchmark::State& state) {
  Linear linear(static_cast<int>(state.range(0)));
  for (auto _ : state) linear.body.work.solver.analyze(linear.body.pattern);
}
BENCHMARK(analysis)->Apply(sizes);

void factorization(benchmark::State& state) {
  Linear linear(static_cast<int>(state.range(0)));
  for (auto _ : state)
    benchmark::DoNotOptimize(linear.body.work.solver.factorize(linear.body.work.stiffness));
}
BENCHMARK(factorization)->Apply(sizes);

void solve(benchmark::State& state) {
  Linear linear(static_cast<int>(state.range(0)));
  auto x = linear.body.work.residual;
  for (auto _ : state) linear.body.work.solver.solve(linear.body.work.residual, x);
}
BENCHMARK(solve)->Apply(sizes);

void contact(benchmark::State& state) {
  Linear linear(static_cast<int>(state.range(0)));
  std::vector<char> closed(linear.body.problem.contact.size(), 1);
  for (auto _ : state) {
    mechanics::StepConstraints<2> constraints(linear.body.problem, closed,
                                              mechanics::round_off_force(linear.body.problem));
    benchmark::DoNotOptimize(constraints.update(linear.u, linear.body.work.residual, false));
  }
}
BENCHMARK(contact)->Apply(sizes);

void heat_step(benchmark::State& state) {
  const int cells = static_cast<int>(state.range(0));
  const casting::Case c = support::load_case("start-2d-thickness");
  const auto mesh = verification::uniform_rectangle(0.28, 0.1, cells, cells, mesh::ElementKind::p1);
  thermal::HeatSolver solver(material::ThermalProperties(c.alloy), c.cooling,
                             thermal::make_heat_forms(mesh, c.section.kind));
  thermal::HeatStepInput input;
  input.time_step = 1.0;
  input.metal_level = 0.1;
  input.casting_temperature = 680.0;
  input.water_flow = 1.5e-3;
  thermal::HeatField start = solver.uniform_field(680.0);
  for (int i = 0; i < 5; ++i) benchmark::DoNotOptimize(solver.step(start, input));
  int iterations = 0;
  for (auto _ : state) {
    thermal::HeatField field = start;
    iterations = solver.step(field, input).iterations;
  }
  state.counters["iterations"] = iterations;
}
BENCHMARK(heat_step)->Apply(sizes);

}  // namespace
