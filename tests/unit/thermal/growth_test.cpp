#include "core/thermal/growth.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/thermal/heat_forms.hpp"
#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::thermal {
namespace {

using mesh::ElementKind;
using mesh::SectionKind;
using testing::casting_section;

std::unique_ptr<HeatForms> forms_of(const mesh::Mesh2D& mesh, SectionKind kind) {
  auto forms = make_heat_forms(mesh, kind);
  forms->update();
  return forms;
}

double total(const HeatForms& forms, const std::vector<double>& enthalpy) {
  const auto& volume = forms.volume();
  return std::inner_product(volume.begin(), volume.end(), enthalpy.begin(), 0.0);
}

class Growth : public ::testing::TestWithParam<std::tuple<ElementKind, SectionKind, double>> {};

/// A small stretch; a stretch that divides the top row; one that adds several rows at once.
TEST_P(Growth, HeatRisesByTheMetalThatEnters) {
  const auto [element, kind, rise] = GetParam();
  mesh::SlabMesh2D slab(casting_section(element));
  std::vector<double> enthalpy;
  for (int n = 0; n < slab.mesh().nodes(); ++n) {
    const double* x = slab.mesh().point(n);
    enthalpy.push_back(2.5e9 - 8e8 * x[0] * x[0] + 3e9 * x[1] + 1e8 * std::sin(40.0 * x[0]));
  }
  const auto forms = forms_of(slab.mesh(), kind);
  const double before = total(*forms, enthalpy);
  slab.grow_to(0.10 + rise);
  bool new_pattern = false;
  const MetalEntry entry = forms->follow_growth(slab.nodes_per_row(), 2.9e9, enthalpy, new_pattern);
  const double face = kind == SectionKind::axisymmetric ? 0.5 * 0.28 * 0.28 : 0.28;

  ASSERT_EQ(enthalpy.size(), std::size_t(slab.mesh().nodes()));
  // Two sums of some hundred terms in different orders: their rounding is a few units in the last
  // place.
  EXPECT_NEAR(entry.stored_before / before, 1.0, 1e-14);
  EXPECT_NEAR(entry.entered / (face * rise * 2.9e9), 1.0, 1e-11);
  EXPECT_NEAR(total(*forms, enthalpy) / (before + entry.entered), 1.0, 1e-14);
}

TEST_P(Growth, UniformMetalStaysUniform) {
  const auto [element, kind, rise] = GetParam();
  mesh::SlabMesh2D slab(casting_section(element));
  std::vector<double> enthalpy(std::size_t(slab.mesh().nodes()), 2.9e9);
  const auto forms = forms_of(slab.mesh(), kind);
  slab.grow_to(0.10 + rise);
  bool new_pattern = false;
  forms->follow_growth(slab.nodes_per_row(), 2.9e9, enthalpy, new_pattern);
  for (const double h : enthalpy) EXPECT_NEAR(h / 2.9e9, 1.0, 1e-13);
}

/// Frozen below, liquid at the top, another profile in every column: nothing may leave the range.
TEST_P(Growth, NewRowsStayBetweenTheirNeighbours) {
  const auto [element, kind, rise] = GetParam();
  mesh::SlabMesh2D slab(casting_section(element));
  std::vector<double> enthalpy;
  for (int n = 0; n < slab.mesh().nodes(); ++n) {
    enthalpy.push_back(n % 2 == 0 && slab.mesh().point(n)[1] < 0.0999 ? 1.2e9 : 2.9e9);
  }
  const auto forms = forms_of(slab.mesh(), kind);
  slab.grow_to(0.10 + rise);
  bool new_pattern = false;
  forms->follow_growth(slab.nodes_per_row(), 2.9e9, enthalpy, new_pattern);
  for (const double h : enthalpy) {
    EXPECT_GE(h, 1.2e9 * (1.0 - 1e-14));
    EXPECT_LE(h, 2.9e9 * (1.0 + 1e-14));
  }
}

TEST_P(Growth, LinearProfileStaysLinearOnRectangles) {
  const auto [element, kind, rise] = GetParam();
  if (element == ElementKind::p1) GTEST_SKIP() << "triangles conserve, see growth.cpp";
  mesh::SlabMesh2D slab(casting_section(element));
  const double below = slab.row_heights()[slab.row_heights().size() - 2];
  std::vector<double> enthalpy(std::size_t(slab.mesh().nodes()), 1e9);
  std::fill(enthalpy.end() - slab.nodes_per_row(), enthalpy.end(), 2e9);
  const auto forms = forms_of(slab.mesh(), kind);
  const std::size_t old_nodes = enthalpy.size();
  const bool divided = !slab.grow_to(0.10 + rise).empty();
  bool new_pattern = false;
  forms->follow_growth(slab.nodes_per_row(), 2e9, enthalpy, new_pattern);
  const std::size_t row = std::size_t(slab.nodes_per_row());
  const std::size_t below_row = old_nodes - 2 * row;
  const double low = enthalpy[below_row], high = enthalpy.back();
  for (std::size_t n = below_row; divided && n < enthalpy.size(); ++n) {
    const double share =
        (slab.mesh().point(static_cast<int>(n))[1] - below) / (slab.level() - below);
    EXPECT_NEAR(enthalpy[n] / (low + share * (high - low)), 1.0, 1e-13);
  }
}

INSTANTIATE_TEST_SUITE_P(Sections, Growth,
                         ::testing::Combine(::testing::Values(ElementKind::p1, ElementKind::q1),
                                            ::testing::Values(SectionKind::plane_strain,
                                                              SectionKind::axisymmetric),
                                            ::testing::Values(0.001, 0.005, 0.031)));

}  // namespace
}  // namespace dccast::thermal
