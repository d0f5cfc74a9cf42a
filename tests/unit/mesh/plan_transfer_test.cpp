// Fields between the heat's and the mechanics' mesh of a quarter slab.
#include "core/mesh/plan_transfer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/mesh/slab_mesh.hpp"
#include "tests/support/quarter_section.hpp"

namespace dccast::mesh {
namespace {

constexpr double length = 0.66, thickness = 0.285, depth = 0.07;

SectionSpec straight() {
  SectionSpec spec = testing::quarter_section(
      ElementKind::q1_bending, {length, Curve(thickness), depth}, {5, 4, 3, 0.08, 0.05, 0.01});
  spec.growth_cell = 0.012;
  spec.heat_cells = {.per_column = 3, .per_layer = 2};
  return spec;
}

SectionSpec convex_and_round() {
  SectionSpec spec = straight();
  spec.half_thickness = Curve(Abscissa::distance, {0.0, 0.3, length}, {0.305, 0.303, thickness});
  spec.corner_radius = 0.17;
  return spec;
}

using Field = std::function<double(double x, double y, double z)>;

std::vector<double> at_nodes(const Mesh3D& mesh, const Field& field) {
  std::vector<double> values;
  for (int n = 0; n < mesh.nodes(); ++n) {
    const double* p = mesh.point(n);
    values.push_back(field(p[0], p[1], p[2]));
  }
  return values;
}

/// Volume of a brick with vertical sides [m3].
double volume_of(const Mesh3D& mesh, int e) {
  const int* n = mesh.nodes_of(e);
  double twice = 0.0;
  for (int k = 0; k < 4; ++k) {
    const double *a = mesh.point(n[k]), *b = mesh.point(n[(k + 1) % 4]);
    twice += a[0] * b[1] - b[0] * a[1];
  }
  return 0.5 * twice * (mesh.point(n[4])[2] - mesh.point(n[0])[2]);
}

class PlanTransferOf : public ::testing::TestWithParam<bool> {
protected:
  PlanTransferOf() { slab.grow_to(depth + 0.031); }

  SectionSpec spec = GetParam() ? convex_and_round() : straight();
  SlabMesh3D slab{spec};
  PlanTransfer transfer{spec};
};

TEST_P(PlanTransferOf, EveryMechanicsNodeIsAHeatNode) {
  const Mesh3D &mechanics = slab.mesh(), &heat = slab.heat_mesh();
  ASSERT_GT(heat.nodes(), 4 * mechanics.nodes());
  for (int axis = 0; axis < 3; ++axis) {
    const auto coordinate = [axis](double x, double y, double z) {
      return std::array{x, y, z}[std::size_t(axis)];
    };
    const auto exact = at_nodes(mechanics, coordinate);
    const auto carried = transfer.at_mechanics_nodes(at_nodes(heat, coordinate));
    ASSERT_EQ(carried.size(), exact.size());
    for (std::size_t n = 0; n < exact.size(); ++n) EXPECT_NEAR(carried[n], exact[n], 1e-14);
  }
}

TEST_P(PlanTransferOf, MeansKeepTheIntegralOfAnyField) {
  const auto field = at_nodes(slab.heat_mesh(), [](double x, double y, double z) {
    return 600.0 + 80.0 * std::sin(9.0 * x) * std::cos(20.0 * y) + 900.0 * z;
  });
  const auto means = transfer.element_means<3>(slab.heat_mesh(), field);
  ASSERT_EQ(means.size(), std::size_t(slab.mesh().elements()));

  // The heat cells of a mechanics' cell fill it; at a round corner they are its volume.
  std::vector<double> volume(means.size(), 0.0);
  std::vector<int> number(means.size());
  for (int e = 0; e < slab.mesh().elements(); ++e) number[std::size_t(e)] = e;
  const std::vector<int> around = transfer.in_heat_elements(number);
  ASSERT_EQ(around.size(), std::size_t(slab.heat_mesh().elements()));

  double integral = 0.0;
  for (int e = 0; e < slab.heat_mesh().elements(); ++e) {
    const double part = volume_of(slab.heat_mesh(), e);
    volume[std::size_t(around[std::size_t(e)])] += part;
    integral += part * mean_at_nodes<3>(slab.heat_mesh(), e, field);
  }
  double carried = 0.0;
  for (std::size_t e = 0; e < means.size(); ++e) carried += volume[e] * means[e];
  EXPECT_NEAR(carried, integral, 1e-13 * integral);

  if (GetParam()) return;
  for (int e = 0; e < slab.mesh().elements(); ++e)
    EXPECT_NEAR(volume[std::size_t(e)], volume_of(slab.mesh(), e), 1e-15);
}

TEST_P(PlanTransferOf, ALinearDisplacementIsCarriedExactly) {
  const auto linear = [](double x, double y, double z) { return 1.0 + 2.0 * x - 3.0 * y + z; };
  const auto carried = transfer.at_heat_nodes(at_nodes(slab.mesh(), linear));
  const auto exact = at_nodes(slab.heat_mesh(), linear);
  ASSERT_EQ(carried.size(), exact.size());

  // An arc of more chords bulges beyond the coarser ones.
  const double bulge = GetParam() ? 0.17 * (1.0 - std::cos(std::acos(-1.0) / 16.0)) : 1e-14;
  for (std::size_t n = 0; n < exact.size(); ++n) EXPECT_NEAR(carried[n], exact[n], 4.0 * bulge);
}

/// The surface of the mechanics' cells is bilinear, and so is what is carried.
TEST_P(PlanTransferOf, ValuesAtCommonNodesStayAsTheyAre) {
  std::vector<double> vectors;
  for (int i = 0; i < 3 * slab.mesh().nodes(); ++i) vectors.push_back(std::sin(7.0 * i));
  const auto carried = transfer.at_heat_nodes(vectors, 3);

  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> component;
    for (std::size_t n = c; n < carried.size(); n += 3) component.push_back(carried[n]);
    const auto back = transfer.at_mechanics_nodes(component);
    for (std::size_t n = 0; n < back.size(); ++n) EXPECT_EQ(back[n], vectors[3 * n + c]);
  }
}

/// A pressure between block and slab pushes as hard on either mesh.
TEST(PlanTransfer, ACarriedPressureHasTheSameForce) {
  const SectionSpec spec = straight();
  const SlabMesh3D slab(spec);
  std::vector<double> pressure;
  for (int n = 0; n < slab.mesh().nodes(); ++n) pressure.push_back(2.0 + std::sin(7.0 * n));

  const auto force = [](const Mesh3D& mesh, const std::vector<double>& values) {
    double sum = 0.0;
    for (const auto& facet : mesh.facets(PatchKind::bottom)) {
      const double area =
          volume_of(mesh, facet.element) / (mesh.point(mesh.nodes_of(facet.element)[4])[2]);
      for (const int n : facet.node) sum += 0.25 * area * values[std::size_t(n)];
    }
    return sum;
  };
  const double before = force(slab.mesh(), pressure);
  const auto carried = PlanTransfer(spec).at_heat_nodes(pressure);
  EXPECT_NEAR(force(slab.heat_mesh(), carried), before, 1e-13 * before);
}

TEST(PlanTransfer, OnOneMeshNothingChanges) {
  SectionSpec spec = straight();
  spec.heat_cells = {};
  const SlabMesh3D slab(spec);
  const PlanTransfer transfer(spec);
  EXPECT_TRUE(transfer.same_mesh());
  EXPECT_EQ(&slab.mesh(), &slab.heat_mesh());

  const auto field = at_nodes(slab.mesh(), [](double x, double y, double z) { return x + y * z; });
  EXPECT_EQ(transfer.at_mechanics_nodes(field), field);
  EXPECT_EQ(transfer.at_heat_nodes(field), field);
  const auto means = transfer.element_means<3>(slab.mesh(), field);
  for (int e = 0; e < slab.mesh().elements(); ++e)
    EXPECT_EQ(means[std::size_t(e)], mean_at_nodes<3>(slab.mesh(), e, field));
}

INSTANTIATE_TEST_SUITE_P(Plans, PlanTransferOf, ::testing::Bool(), [](const auto& round) {
  return round.param ? "convex_and_round" : "straight";
});

}  // namespace
}  // namespace dccast::mesh
