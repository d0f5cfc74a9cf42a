// Seconds of an element in three dimensions: strains and forces, stiffness with its assembly.

#include <benchmark/benchmark.h>

#include "tests/unit/mechanics/box_mesh.hpp"
#include "tests/verification/mechanics/fixed_body.hpp"

namespace {

using namespace dccast;
using namespace dccast::mechanics::testing;

/// A creeping box of 1000 cells under a stretch that varies in space.
template <class Element>
struct Scene {
  Scene() : body(box_mesh({10, 10, 10}, Element::nodes == 4, [](const Vector3& s) { return s; })) {
    body.set_material(5e10, 0.4, 1e-40);
    for (int n = 0; n < body.mesh.nodes(); ++n) {
      const Vector3 x = body.place(n);
      u.insert(u.end(),
               {1e-3 * x[0] * (1.0 + x[1]), -5e-4 * x[1] * (1.0 + x[2]), 1e-4 * x[2] * x[0]});
    }
  }
  verification::FixedBody<Element> body;
  std::vector<double> u;
};

template <class Element>
void count(benchmark::State& state, const Scene<Element>& scene) {
  state.SetItemsProcessed(state.iterations() * scene.body.mesh.elements());
}

template <class Element>
void solid_residual(benchmark::State& state) {
  Scene<Element> scene;
  mechanics::Equilibrium equilibrium(scene.body.problem);
  for (auto _ : state) {
    benchmark::DoNotOptimize(equilibrium.residual(scene.u, scene.body.work.residual,
                                                  mechanics::return_map_law(scene.body.problem)));
  }
  count(state, scene);
}
BENCHMARK(solid_residual<fem::P1Tetrahedron>);
BENCHMARK(solid_residual<fem::Q1Hexahedron>);
BENCHMARK(solid_residual<fem::BendingHexahedron>);

template <class Element>
void solid_stiffness(benchmark::State& state) {
  Scene<Element> scene;
  mechanics::Equilibrium equilibrium(scene.body.problem);
  equilibrium.residual(scene.u, scene.body.work.residual,
                       mechanics::return_map_law(scene.body.problem));
  for (auto _ : state) equilibrium.tangent(scene.body.work.stiffness);
  count(state, scene);
}
BENCHMARK(solid_stiffness<fem::P1Tetrahedron>);
BENCHMARK(solid_stiffness<fem::Q1Hexahedron>);
BENCHMARK(solid_stiffness<fem::BendingHexahedron>);

}  // namespace
