#include "core/thermal/heat_forms.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::thermal {
namespace {

using mesh::ElementKind;
using mesh::SectionKind;
using testing::casting_section;

class HeatFormsOfSection : public ::testing::TestWithParam<std::tuple<ElementKind, SectionKind>> {
protected:
  ElementKind element() const { return std::get<0>(GetParam()); }
  SectionKind kind() const { return std::get<1>(GetParam()); }
  bool round() const { return kind() == SectionKind::axisymmetric; }
};

TEST_P(HeatFormsOfSection, VolumesSumToTheSection) {
  const mesh::SlabMesh2D slab(casting_section(element()));
  const auto forms = make_heat_forms(slab.mesh(), kind());
  forms->update();
  const auto& volume = forms->volume();
  const double expected = round() ? 0.5 * 0.28 * 0.28 * 0.1 : 0.28 * 0.1;
  EXPECT_NEAR(std::accumulate(volume.begin(), volume.end(), 0.0), expected, 1e-14);
  for (const double v : volume) EXPECT_GT(v, 0.0);
}

/// Patch test: a temperature linear in height makes no source inside; and the heat that passes the
/// bottom is its gradient times the area.
TEST_P(HeatFormsOfSection, LinearFieldIsInEquilibrium) {
  const mesh::SlabMesh2D slab(casting_section(element()));
  const auto forms = make_heat_forms(slab.mesh(), kind());
  EXPECT_TRUE(forms->update());
  EXPECT_FALSE(forms->update());
  std::vector<double> theta, source(std::size_t(forms->nodes()));
  for (int n = 0; n < forms->nodes(); ++n) theta.push_back(7.0 * slab.mesh().point(n)[1]);
  linalg::multiply(forms->pattern(), forms->stiffness(), theta, source);
  double bottom = 0.0;
  const std::size_t row = std::size_t(slab.nodes_per_row());
  for (std::size_t n = 0; n < row; ++n) bottom -= source[n];
  for (std::size_t n = row; n < source.size() - row; ++n) EXPECT_NEAR(source[n], 0.0, 1e-13);
  EXPECT_NEAR(bottom, 7.0 * (round() ? 0.5 * 0.28 * 0.28 : 0.28), 1e-13);
}

/// Maximum principle: no positive coupling, whatever the aspect ratio of the graded cells.
TEST_P(HeatFormsOfSection, CouplingsAreNeverPositive) {
  const mesh::SlabMesh2D slab(casting_section(element()));
  const auto forms = make_heat_forms(slab.mesh(), kind());
  forms->update();
  const auto& start = forms->pattern().column_start();
  for (std::size_t c = 0; c + 1 < start.size(); ++c) {
    EXPECT_GT(forms->stiffness()[std::size_t(start[c])], 0.0);
    for (std::size_t k = std::size_t(start[c]) + 1; k < std::size_t(start[c + 1]); ++k) {
      EXPECT_LE(forms->stiffness()[k], 1e-14);
    }
  }
}

/// Oblique cells: no source inside from a field that is linear in height.
TEST_P(HeatFormsOfSection, LinearFieldIsInEquilibriumOnObliqueCells) {
  mesh::Mesh2D mesh = mesh::SlabMesh2D(casting_section(element())).mesh();
  std::vector<char> inside(std::size_t(mesh.nodes()), 1);
  for (const auto& patch : mesh.patches)
    for (const int n : mesh::patch_nodes(patch)) inside[std::size_t(n)] = 0;
  for (std::size_t n = 0; n < inside.size(); ++n) {
    if (inside[n] == 0) continue;
    mesh.node[2 * n] += 0.8e-3 * std::sin(7.0 * static_cast<double>(n));
    mesh.node[2 * n + 1] += 0.8e-3 * std::cos(5.0 * static_cast<double>(n));
  }
  const auto forms = make_heat_forms(mesh, kind());
  forms->update();
  std::vector<double> theta, source(inside.size());
  for (int n = 0; n < mesh.nodes(); ++n)
    theta.push_back(7.0 * mesh.point(n)[1] + (round() ? 0.0 : 3.0 * mesh.point(n)[0]));
  linalg::multiply(forms->pattern(), forms->stiffness(), theta, source);
  for (std::size_t n = 0; n < source.size(); ++n) {
    if (inside[n] != 0) {
      EXPECT_NEAR(source[n], 0.0, 1e-13);
    }
  }
}

/// A run that goes on from a checkpoint makes its forms anew: they must be the same bit by bit. The
/// mesh stretches, gets a row, several, and goes back to where it was.
TEST_P(HeatFormsOfSection, FormsThatFollowAMeshAreThoseMadeOfIt) {
  mesh::SlabMesh2D slab(casting_section(element()));
  const std::vector<double> rows = slab.row_heights();
  const auto followed = make_heat_forms(slab.mesh(), kind());
  followed->update();
  const auto expect_same = [&] {
    followed->update();
    const auto anew = make_heat_forms(slab.mesh(), kind());
    anew->update();
    EXPECT_EQ(followed->pattern().row(), anew->pattern().row());
    EXPECT_TRUE(std::ranges::equal(followed->stiffness(), anew->stiffness()));
    EXPECT_EQ(followed->volume(), anew->volume());
    EXPECT_EQ(followed->bottom_weight(), anew->bottom_weight());
    EXPECT_EQ(followed->top_nodes(), anew->top_nodes());
  };
  for (const double level : {0.1005, 0.106, 0.107, 0.125}) {
    slab.grow_to(level);
    expect_same();
  }
  slab.restore(rows);
  expect_same();
}

INSTANTIATE_TEST_SUITE_P(Sections, HeatFormsOfSection,
                         ::testing::Combine(::testing::Values(ElementKind::p1, ElementKind::q1),
                                            ::testing::Values(SectionKind::plane_strain,
                                                              SectionKind::axisymmetric)));

}  // namespace
}  // namespace dccast::thermal
