#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/casting/findings/motion.hpp"
#include "core/casting/findings/mush_strain.hpp"
#include "core/casting/findings/shell.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "tests/support/print_kinds.hpp"

namespace dccast::casting {
namespace {

constexpr double isotherm = 620.0;  // [°C]

mesh::SectionSpec section(mesh::ElementKind element, mesh::SectionKind kind) {
  mesh::SectionSpec spec;
  spec.kind = kind;
  spec.element = element;
  spec.half_width = 0.28;
  spec.half_thickness = Curve(0.2);
  spec.initial_depth = 0.10;
  spec.columns = 9;
  spec.layers = 6;
  spec.rows = 7;
  spec.side_cell = spec.wide_side_cell = spec.bottom_cell = 0.01;
  return spec;
}

/// A temperature at every node.
template <int Dim, class Field>
std::vector<double> at_nodes(const mesh::Mesh<Dim>& mesh, Field&& field) {
  std::vector<double> values;
  for (int n = 0; n < mesh.nodes(); ++n) values.push_back(field(mesh.point(n)));
  return values;
}

class In2D : public ::testing::TestWithParam<mesh::ElementKind> {
protected:
  const mesh::SlabMesh2D slab{section(GetParam(), mesh::SectionKind::plane_strain)};
  const mesh::Mesh2D& mesh = slab.mesh();
};

/// A field that is linear everywhere is met exactly, at any height.
TEST_P(In2D, TheShellIsAsThickAsALinearFieldSays) {
  for (const double height : {0.0, 0.033, 0.1}) {
    const double shell = 0.02 + 0.1 * height;
    const auto field = at_nodes(mesh, [](const double* p) {
      return isotherm + 3000.0 * (0.28 - p[0] - 0.02 - 0.1 * p[1]);
    });
    const auto slice = slice_at(mesh, field, height, isotherm);
    ASSERT_TRUE(slice);
    EXPECT_NEAR(slice->shell.value, shell, 1e-12);
    EXPECT_NEAR(slice->shell.place[0], 0.28 - shell, 1e-12);
    EXPECT_NEAR(slice->surface.value, isotherm - 3000.0 * shell, 1e-9);
    EXPECT_EQ(hottest_side_at(mesh, field, height)->value, slice->surface.value);
  }
}

TEST_P(In2D, WhereTheSideIsHotThereIsNoShellAndWhereNothingIsTheSlabIsTheShell) {
  const std::vector<double> hot(std::size_t(mesh.nodes()), isotherm);
  EXPECT_EQ(slice_at(mesh, hot, 0.05, isotherm)->shell.value, 0.0);
  const std::vector<double> cold(std::size_t(mesh.nodes()), 20.0);
  EXPECT_NEAR(slice_at(mesh, cold, 0.05, isotherm)->shell.value, 0.28, 1e-12);
  EXPECT_FALSE(slice_at(mesh, cold, 0.2, isotherm)) << "no slab there";
  EXPECT_FALSE(hottest_side_at(mesh, cold, 0.2)) << "no slab there";
}

TEST_P(In2D, TheBottomShellIsTheLeastHeightOfTheIsotherm) {
  const auto field = at_nodes(
      mesh, [](const double* p) { return isotherm + 4000.0 * (p[1] - 0.03 - 0.1 * p[0]); });
  const auto shell = bottom_shell(mesh, field, isotherm);
  EXPECT_NEAR(shell.value, 0.03, 1e-12);
  EXPECT_NEAR(shell.place[0], 0.0, 1e-12);
  EXPECT_EQ(shell.place[1], 0.0);
  const std::vector<double> hot(std::size_t(mesh.nodes()), isotherm);
  EXPECT_EQ(bottom_shell(mesh, hot, isotherm).value, 0.0);
  const std::vector<double> cold(std::size_t(mesh.nodes()), 20.0);
  EXPECT_NEAR(bottom_shell(mesh, cold, isotherm).value, 0.10, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Elements, In2D,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1));

class In3D : public ::testing::TestWithParam<mesh::ElementKind> {
protected:
  const mesh::SlabMesh3D slab{section(GetParam(), mesh::SectionKind::quarter_slab)};
  const mesh::Mesh3D& mesh = slab.mesh();
};

/// Thinner at the narrow face than at the wide one.
TEST_P(In3D, TheShellIsTheLeastOverBothFaces) {
  const auto narrow =
      at_nodes(mesh, [](const double* p) { return isotherm + 3000.0 * (0.28 - p[0] - 0.03); });
  const auto slice = slice_at(mesh, narrow, 0.04, isotherm);
  ASSERT_TRUE(slice);
  EXPECT_EQ(slice->shell.value, 0.0) << "the wide face is hot from its middle to the corner";
  const auto both = at_nodes(mesh, [](const double* p) {
    return isotherm + 3000.0 * std::min(0.28 - p[0] - 0.05, 0.2 - p[1] - 0.04);
  });
  EXPECT_NEAR(slice_at(mesh, both, 0.04, isotherm)->shell.value, 0.04, 2e-3);
}

TEST_P(In3D, TheBottomShellIsTheLeastHeightOfTheIsotherm) {
  const auto field = at_nodes(
      mesh, [](const double* p) { return isotherm + 4000.0 * (p[2] - 0.03 - 0.1 * p[1]); });
  EXPECT_NEAR(bottom_shell(mesh, field, isotherm).value, 0.03, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Elements, In3D,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1));

/// Q diag(1, 2, 3) Q' for any rotation Q has the largest principal value 3.
TEST(LargestPrincipal, IsThatOfATurnedTensor) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(0.0, 6.28);
  for (int i = 0; i < 20; ++i) {
    const double a = angle(random), b = angle(random);
    const double q[3][3] = {{std::cos(a), -std::sin(a) * std::cos(b), std::sin(a) * std::sin(b)},
                            {std::sin(a), std::cos(a) * std::cos(b), -std::cos(a) * std::sin(b)},
                            {0.0, std::sin(b), std::cos(b)}};
    const auto entry = [&](int r, int s) {
      return 1.0 * q[r][0] * q[s][0] + 2.0 * q[r][1] * q[s][1] + 3.0 * q[r][2] * q[s][2];
    };
    const SymmetricTensor<3> t{
        {entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(1, 2), entry(0, 2)}};
    EXPECT_NEAR(largest_principal(t), 3.0, 1e-9);
  }
  EXPECT_NEAR(largest_principal(SymmetricTensor<3>{{2.0, 2.0, 2.0, 0, 0, 0}}), 2.0, 1e-15);
  EXPECT_NEAR(largest_principal(SymmetricTensor<2>{{1.0, 1.0, 9.0, 0.5}}), 1.5, 1e-15)
      << "what plane strain imposes across the section is left out";
}

/// One element in the mush has been stretched, one in the solid more, one that grows most.
TEST(MushStrain, IsThatOfSolidMetalAboveTheSolidusAlone) {
  const mesh::SlabMesh2D slab(section(mesh::ElementKind::q1, mesh::SectionKind::plane_strain));
  const mesh::Mesh2D& mesh = slab.mesh();
  const int last = mesh.elements() - 1;
  mechanics::SlabState<2> state;
  state.started = true;
  state.solid.assign(std::size_t(mesh.elements()), 1);
  state.viscoplastic.resize(std::size_t(mesh.elements()));
  state.viscoplastic[0] = {{0.02, -0.02, 0.0, 0.0}};
  state.viscoplastic[30] = {{0.01, -0.01, 0.03, 0.0}};
  state.viscoplastic[std::size_t(last)] = {{0.05, -0.05, 0.0, 0.0}};
  std::vector<double> temperature(std::size_t(mesh.elements()), 630.0);
  temperature[0] = 500.0;
  const auto found = mush_strain(mesh, state, temperature, isotherm, last, false);

  EXPECT_NEAR(found.value, 0.01, 1e-15);
  EXPECT_NEAR(mush_strain(mesh, state, temperature, isotherm, last, true).value, 0.03, 1e-15)
      << "of a billet the hoop counts";

  state.solid[30] = 0;
  EXPECT_EQ(mush_strain(mesh, state, temperature, isotherm, last, true).value, 0.0);
}

}  // namespace
}  // namespace dccast::casting
