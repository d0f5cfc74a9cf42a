// What a contact iteration costs when only the contact set changes and the stiffness stays, on a
// square of 1.3k, 20k and 80k triangles: a factorisation anew against condensation.
// docs/developers/factorisation.md has the figures.

#include <benchmark/benchmark.h>

#include <ctime>
#include <stdexcept>

#include "core/linalg/condensation.hpp"
#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/constrained_system.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "tests/verification/mechanics/fixed_body.hpp"

namespace {

using namespace dccast;
using Element = fem::P1Triangle;
using Body = verification::FixedBody<Element>;

/// A creeping square on a bottom that touches on its inner half, its stiffness, and a set in which
/// some pairs have moved: half of them opened at the edge of the contact, half closed beyond it.
struct Scene {
  Scene(int cells, int changed)
      : body(verification::uniform_rectangle(0.5, 0.5, cells, cells, mesh::ElementKind::p1)) {
    body.set_material(5e10, 0.4, 1e-40, 6.0);
    body.set_contact();
    body.problem.dt = 1.0;
    for (int n : mesh::patch_nodes(body.mesh, mesh::PatchKind::symmetry)) body.fix(n, 0, 0.0);
    for (int n = 0; n < body.mesh.nodes(); ++n) {
      const double x = body.mesh.point(n)[0], y = body.mesh.point(n)[1];
      u.push_back(1e-3 * x * (1.0 + y));
      u.push_back(-5e-4 * y * (1.0 + x));
    }
    mechanics::Equilibrium equilibrium(body.problem);
    equilibrium.residual(u, body.work.residual, mechanics::return_map_law(body.problem));
    stiffness.resize(body.pattern.entries());
    equilibrium.tangent(stiffness);
    place_contact(changed);
  }

  void place_contact(int changed) {
    const auto& contact = body.problem.contact;
    const int edge = static_cast<int>(contact.size()) / 2;
    before = after = body.problem.fixed;
    for (int i = 0; i < static_cast<int>(contact.size()); ++i) {
      const std::size_t unknown = std::size_t(contact[std::size_t(i)]);
      before[unknown] = i < edge;
      const bool moves = i >= edge - (changed + 1) / 2 && i < edge + changed / 2;
      after[unknown] = moves ? i >= edge : i < edge;
    }
  }

  Body body;
  std::vector<double> u, stiffness;
  std::vector<char> before, after;  ///< (unknown) held
};

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Seconds of this thread in one call; what happens outside of it does not count.
template <class Call>
void measure(benchmark::State& state, Call&& call) {
  const double start = thread_seconds();
  call();
  state.SetIterationTime(thread_seconds() - start);
}

void require(bool done) {
  if (!done) throw std::logic_error("the matrix of the scene is positive definite");
}

/// The system of the mechanics: everything anew.
void full(benchmark::State& state) {
  Scene scene(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  auto& work = scene.body.work;
  mechanics::ConstrainedSystem system(scene.body.pattern, work);
  const std::vector<double> none(scene.u.size(), 0.0);
  for (auto _ : state) {
    work.stiffness = scene.stiffness;
    measure(state, [&] {
      require(system.factorize(scene.after, none));
      require(system.solve(scene.after, none));
    });
  }
}

void condensation(benchmark::State& state) {
  Scene scene(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  auto& work = scene.body.work;
  mechanics::ConstrainedSystem system(scene.body.pattern, work);
  const std::vector<double> none(scene.u.size(), 0.0);
  work.stiffness = scene.stiffness;
  require(system.factorize(scene.before, none));
  std::vector<double> x(scene.u.size());
  for (auto _ : state) {
    linalg::Condensation condensed(16);
    condensed.start(scene.body.pattern, scene.stiffness, work.solver, scene.before);
    measure(state, [&] {
      require(condensed.change(scene.after));
      condensed.solve(work.residual, x);
    });
  }
}

void one_solve(benchmark::State& state) {
  Scene scene(static_cast<int>(state.range(0)), 1);
  auto& work = scene.body.work;
  mechanics::ConstrainedSystem system(scene.body.pattern, work);
  const std::vector<double> none(scene.u.size(), 0.0);
  work.stiffness = scene.stiffness;
  require(system.factorize(scene.before, none));
  for (auto _ : state) {
    measure(state, [&] { require(system.solve(scene.before, none)); });
  }
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"cells"})->UseManualTime()->Unit(benchmark::kMillisecond);
  for (int cells : {26, 100, 200}) b->Arg(cells);
}

void sizes_and_changes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"cells", "pairs"})->UseManualTime()->Unit(benchmark::kMillisecond);
  for (int cells : {26, 100, 200}) {
    for (int pairs : {1, 4, 16}) b->Args({cells, pairs});
  }
}

BENCHMARK(full)->Name("contact/full")->Apply(sizes_and_changes);
BENCHMARK(condensation)->Name("contact/condensation")->Apply(sizes_and_changes);
BENCHMARK(one_solve)->Name("contact/one_solve")->Apply(sizes);

}  // namespace
