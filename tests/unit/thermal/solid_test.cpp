// Heat in a quarter slab: forms, faces, growth, balance, and the sections it must agree with.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/thermal/heat_solver.hpp"
#include "tests/support/quarter_section.hpp"
#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::thermal {
namespace {

using mesh::ElementKind;
using mesh::PatchKind;
using mesh::SectionKind;
using testing::casting_alloy;
using testing::casting_cooling;

constexpr double half_length = 0.66, half_thickness = 0.28, depth = 0.10;

mesh::SectionSpec quarter_slab(ElementKind element, bool convex = false) {
  const Curve opening =
      convex ? Curve(Abscissa::distance, {0.2, 0.5, half_length}, {0.285, 0.282, 0.275})
             : Curve(half_thickness);
  mesh::SectionSpec section = dccast::testing::quarter_section(
      element, {half_length, opening, depth}, {8, 6, 10, 0.006, 0.005, 0.004});
  section.growth_cell = 0.008;
  return section;
}

double plan_area(bool convex) {
  return convex ? quarter_slab(ElementKind::q1, true).half_thickness.integral(0.0, half_length)
                : half_length * half_thickness;
}

class SolidForms : public ::testing::TestWithParam<std::tuple<ElementKind, bool>> {
protected:
  SolidForms() : slab_(quarter_slab(element(), convex())), forms_(make_heat_forms(slab_.mesh())) {
    forms_->update();
  }
  static ElementKind element() { return std::get<0>(GetParam()); }
  static bool convex() { return std::get<1>(GetParam()); }

  mesh::SlabMesh3D slab_;
  std::unique_ptr<HeatForms> forms_;
};

TEST_P(SolidForms, VolumesAndBottomSumToTheSlab) {
  const auto& volume = forms_->volume();
  const auto& bottom = forms_->bottom_weight();
  EXPECT_NEAR(std::accumulate(volume.begin(), volume.end(), 0.0), plan_area(convex()) * depth,
              1e-15);
  EXPECT_NEAR(std::accumulate(bottom.begin(), bottom.end(), 0.0), plan_area(convex()), 1e-14);
  for (const double v : volume) EXPECT_GT(v, 0.0);
}

/// Patch test, on oblique cells too: a linear field has no source inside, and what passes the
/// bottom is its gradient times the area.
TEST_P(SolidForms, LinearFieldIsInEquilibrium) {
  std::vector<char> inside(std::size_t(forms_->nodes()), 1);
  for (const auto& patch : slab_.mesh().patches)
    for (const int n : mesh::patch_nodes(patch)) inside[std::size_t(n)] = 0;
  std::vector<double> theta, source(inside.size());
  for (int n = 0; n < forms_->nodes(); ++n) {
    const double* x = slab_.mesh().point(n);
    theta.push_back(3.0 * x[0] - 5.0 * x[1] + 7.0 * x[2]);
  }
  linalg::multiply(forms_->pattern(), forms_->stiffness(), theta, source);
  for (std::size_t n = 0; n < source.size(); ++n) {
    if (inside[n] != 0) {
      EXPECT_NEAR(source[n], 0.0, 1e-13);
    }
  }
  for (int n = 0; n < forms_->nodes(); ++n) theta[std::size_t(n)] = 7.0 * slab_.mesh().point(n)[2];
  linalg::multiply(forms_->pattern(), forms_->stiffness(), theta, source);
  double bottom = 0.0;
  for (const int n : forms_->bottom_nodes()) bottom -= source[std::size_t(n)];
  EXPECT_NEAR(bottom, 7.0 * plan_area(convex()), 1e-12);
}

/// Cells of any shape, as imported meshes have them.
TEST_P(SolidForms, LinearFieldIsInEquilibriumOnAnyCell) {
  mesh::Mesh3D mesh = slab_.mesh();
  std::vector<char> inside(std::size_t(mesh.nodes()), 1);
  for (const auto& patch : mesh.patches)
    for (const int n : mesh::patch_nodes(patch)) inside[std::size_t(n)] = 0;
  for (std::size_t i = 0; i < mesh.node.size(); ++i)
    if (inside[i / 3] != 0) mesh.node[i] += 0.8e-3 * std::sin(7.0 * static_cast<double>(i));
  const auto forms = make_heat_forms(mesh);
  forms->update();
  std::vector<double> theta, source(inside.size());
  for (int n = 0; n < mesh.nodes(); ++n) {
    const double* x = mesh.point(n);
    theta.push_back(3.0 * x[0] - 5.0 * x[1] + 7.0 * x[2]);
  }
  linalg::multiply(forms->pattern(), forms->stiffness(), theta, source);
  for (std::size_t n = 0; n < source.size(); ++n) {
    if (inside[n] != 0) {
      EXPECT_NEAR(source[n], 0.0, 1e-13);
    }
  }
}

/// Maximum principle on bricks, whatever the aspect ratio of the graded cells.
TEST_P(SolidForms, CouplingsAreNeverPositiveOnBricks) {
  if (convex() || element() == ElementKind::p1) GTEST_SKIP() << "bricks only";
  const auto& start = forms_->pattern().column_start();
  for (std::size_t c = 0; c + 1 < start.size(); ++c) {
    for (std::size_t k = std::size_t(start[c]) + 1; k < std::size_t(start[c + 1]); ++k)
      EXPECT_LE(forms_->stiffness()[k], 1e-14);
  }
}

struct AreaKey {
  int law;
  Face face;
  auto operator<=>(const AreaKey&) const = default;
};

TEST_P(SolidForms, EveryLawGetsItsExactAreaAndMomentOnEachFace) {
  std::vector<SideShare> shares;

  CoolingSpec cooling = casting_cooling();
  cooling.zones[1].face = Face::wide;
  cooling.narrow_water = cooling.water;
  cooling.narrow_water->from = 0.051;
  forms_->divide_side(cooling, {depth, {true, true}, {}}, shares);

  // Area and first moment that each law has on each face.
  std::map<AreaKey, double> area, moment;
  for (const SideShare& share : shares) {
    area[{share.law, share.face}] += share.weight;
    moment[{share.law, share.face}] += share.weight * slab_.mesh().point(share.node)[2];
  }

  // Width of the wide face, along its lowest edges.
  double wide = 0.0;
  for (const auto& patch : slab_.mesh().patches) {
    if (patch.kind != PatchKind::side || patch.name == "side_x") continue;
    for (const auto& facet : patch.facets) {
      const double* a = slab_.mesh().point(facet.node[0]);
      for (int i = 1; i < facet.nodes; ++i) {
        const double* b = slab_.mesh().point(facet.node[std::size_t(i)]);
        // Lower edges of the lowest row only.
        if (a[2] == 0.0 && b[2] == 0.0) wide += std::hypot(b[0] - a[0], b[1] - a[1]);
      }
    }
  }

  const double narrow = convex() ? 0.275 : half_thickness;
  const auto check = [&](int law, Face face, double width, double low, double high) {
    const AreaKey key{law, face};
    EXPECT_NEAR(area[key], width * (high - low), 1e-15);
    EXPECT_NEAR(moment[key], width * 0.5 * (high * high - low * low), 1e-15);
  };

  check(0, Face::wide, wide, 0.07, 0.10);
  check(1, Face::wide, wide, 0.035, 0.07);
  check(law_water, Face::wide, wide, 0.0, 0.035);
  check(0, Face::narrow, narrow, 0.07, 0.10);
  check(law_dry, Face::narrow, narrow, 0.049, 0.07);
  check(law_water, Face::narrow, narrow, 0.0, 0.049);
}

TEST_P(SolidForms, TablesAgainstDistanceAreIntegratedExactly) {
  std::vector<SideShare> shares;
  CoolingSpec cooling = casting_cooling();
  cooling.zones[0].solid_coefficient = {Abscissa::distance, {0.0, 0.011, 0.03}, {400, 150, 10}};
  forms_->divide_side(cooling, {depth, {true, true}, {}}, shares);
  double sum = 0.0, width = 0.0;
  for (const SideShare& share : shares) {
    if (share.law != 0 || share.face != Face::narrow) continue;
    sum += share.weight * cooling.zones[0].solid_coefficient(share.distance);
    width += share.weight / 0.03;
  }
  EXPECT_NEAR(sum, width * cooling.zones[0].solid_coefficient.integral(0.0, 0.03), 1e-13);
}

/// The cooling zones act on the displaced side.
TEST_P(SolidForms, ARisenSideMeetsZonesAtItsHeight) {
  const std::vector<double> rise(std::size_t(forms_->nodes()), 0.004);
  std::vector<SideShare> risen, lower;
  forms_->divide_side(casting_cooling(), {depth, {true, true}, rise}, risen);
  forms_->divide_side(casting_cooling(), {depth - 0.004, {true, true}, {}}, lower);
  ASSERT_EQ(risen.size(), lower.size());
  for (std::size_t i = 0; i < risen.size(); ++i) {
    EXPECT_EQ(risen[i].law, lower[i].law);
    EXPECT_NEAR(risen[i].weight, lower[i].weight, 1e-15);
  }
}

TEST_P(SolidForms, GrowthConservesHeatToRoundOff) {
  for (const double rise : {0.001, 0.005, 0.031}) {
    mesh::SlabMesh3D slab(quarter_slab(element(), convex()));
    const auto forms = make_heat_forms(slab.mesh());
    forms->update();
    std::vector<double> enthalpy;
    for (int n = 0; n < slab.mesh().nodes(); ++n) {
      const double* x = slab.mesh().point(n);
      enthalpy.push_back(2.5e9 - 8e8 * x[0] * x[0] + 3e9 * x[2] + 1e8 * std::sin(40.0 * x[1]));
    }
    const auto total = [&] {
      return std::inner_product(forms->volume().begin(), forms->volume().end(), enthalpy.begin(),
                                0.0);
    };
    const double before = total();
    const bool divided = !slab.grow_to(depth + rise).empty();
    bool new_pattern = false;
    const MetalEntry entry =
        forms->follow_growth(slab.nodes_per_row(), 2.9e9, enthalpy, new_pattern);
    EXPECT_EQ(new_pattern, divided);
    EXPECT_NEAR(entry.entered / (plan_area(convex()) * rise * 2.9e9), 1.0, 1e-11);
    EXPECT_NEAR(total() / (before + entry.entered), 1.0, 2e-14);
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, SolidForms,
                         ::testing::Combine(::testing::Values(ElementKind::p1, ElementKind::q1),
                                            ::testing::Bool()));

HeatStepInput input_at(double time, double time_step, double level) {
  HeatStepInput input;
  input.time = time;
  input.time_step = time_step;
  input.metal_level = level;
  input.casting_temperature = 680.0;
  input.water_flow = 3e-3;
  return input;
}

/// Hold, water, growth; what leaves by the faces is what the balance says.
class SolidCasting : public ::testing::TestWithParam<ElementKind> {};

TEST_P(SolidCasting, ConservesEnergyInEveryStep) {
  mesh::SlabMesh3D slab(quarter_slab(GetParam(), true));
  HeatSolver solver(material::ThermalProperties(casting_alloy()), casting_cooling(),
                    make_heat_forms(slab.mesh()));
  HeatField field = solver.uniform_field(680.0);
  double time = -4.0;
  for (const double dt : {1.0, 1.0, 1.0, 1.0, 0.05, 0.05, 0.2, 0.7, 1.0, 1.0, 1.0, 1.0, 1.0}) {
    time += dt;
    HeatStepInput input = input_at(time, dt, depth + 2e-3 * std::max(time, 0.0));
    slab.grow_to(input.metal_level);
    input.entry = solver.follow_growth(field, slab.nodes_per_row(), 680.0);
    const HeatStepOutcome outcome = solver.step(field, input);
    ASSERT_TRUE(outcome.converged);
    EXPECT_LT(outcome.balance.error, 1e-10);
    const double side = outcome.face_heat_flux[0] + outcome.face_heat_flux[1];
    EXPECT_NEAR(outcome.balance.side / (dt * side), 1.0, 1e-14);
    EXPECT_NEAR(outcome.balance.bottom / (dt * outcome.bottom_heat_flux), 1.0, 1e-14);
  }
  const auto [coldest, hottest] =
      std::minmax_element(field.temperature.begin(), field.temperature.end());

  EXPECT_GT(*coldest, 25.0);
  EXPECT_LT(*coldest, 300.0);
  EXPECT_LE(*hottest, 680.0 + 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Elements, SolidCasting,
                         ::testing::Values(ElementKind::p1, ElementKind::q1));

CoolingSpec cooled_on(Face face) {
  CoolingSpec cooling = casting_cooling();
  cooling.dry_coefficient = 0.0;
  for (SideZone& zone : cooling.zones) zone.face = face;
  cooling.narrow_water = cooling.water;
  (face == Face::wide ? *cooling.narrow_water : cooling.water).enabled = false;
  return cooling;
}

/// One face insulated: every layer along it is the plane section of the other.
class SlabAsSection : public ::testing::TestWithParam<Face> {};

TEST_P(SlabAsSection, AgreesToRoundOff) {
  const bool wide = GetParam() == Face::wide;
  const mesh::SectionSpec solid = quarter_slab(ElementKind::q1);
  mesh::SectionSpec section = solid;
  section.kind = SectionKind::plane_strain;

  // The plane section across the face that is cooled.
  if (wide) {
    section.half_width = half_thickness;
    section.columns = solid.layers;
    section.side_cell = solid.wide_side_cell;
  }

  mesh::SlabMesh3D slab(solid);
  mesh::SlabMesh2D plane(section);
  const material::ThermalProperties metal(casting_alloy());
  HeatSolver in_solid(metal, cooled_on(GetParam()), make_heat_forms(slab.mesh()), 1e-13);
  HeatSolver in_plane(metal, casting_cooling(),
                      make_heat_forms(plane.mesh(), SectionKind::plane_strain), 1e-13);

  HeatField field = in_solid.uniform_field(680.0), plane_field = in_plane.uniform_field(680.0);
  for (int i = 1; i <= 8; ++i) {
    HeatStepInput input = input_at(0.5 * i, 0.5, depth + 2e-3 * i);
    slab.grow_to(input.metal_level);
    plane.grow_to(input.metal_level);
    input.entry = in_solid.follow_growth(field, slab.nodes_per_row(), 680.0);

    const HeatStepOutcome whole = in_solid.step(field, input);
    input.entry = in_plane.follow_growth(plane_field, plane.nodes_per_row(), 680.0);
    const HeatStepOutcome slice = in_plane.step(plane_field, input);
    ASSERT_TRUE(whole.converged && slice.converged);

    const double width = wide ? half_length : half_thickness;
    EXPECT_NEAR(whole.wall_heat_flux / (width * slice.wall_heat_flux), 1.0, 1e-10);
    EXPECT_EQ(whole.face_heat_flux[wide ? 1 : 0], 0.0);
  }

  // Every layer along the insulated face has the temperatures of the section.
  const int per_column = solid.layers + 1;
  for (int n = 0; n < slab.mesh().nodes(); ++n) {
    const int in_row = n % slab.nodes_per_row(), row = n / slab.nodes_per_row();
    const int column = wide ? in_row % per_column : in_row / per_column;
    const double expected =
        plane_field.temperature[std::size_t(row * plane.nodes_per_row() + column)];
    EXPECT_NEAR(field.temperature[std::size_t(n)] / expected, 1.0, 1e-10);
  }
}

INSTANTIATE_TEST_SUITE_P(Faces, SlabAsSection, ::testing::Values(Face::wide, Face::narrow),
                         [](const auto& face) {
                           return face.param == Face::wide ? "wide" : "narrow";
                         });

/// A mesh in another order of elements has no lines that the solver knows, and is factorised.
TEST(SolidSolver, LinesGiveTheAnswerOfAFactor) {
  const mesh::SlabMesh3D slab(quarter_slab(ElementKind::q1, true));
  mesh::Mesh3D mixed = slab.mesh();
  std::swap_ranges(mixed.element_node.begin(), mixed.element_node.begin() + 8,
                   mixed.element_node.begin() + 8);
  ASSERT_TRUE(mesh::extrusion_of(slab.mesh()) && !mesh::extrusion_of(mixed));

  const material::ThermalProperties metal(casting_alloy());
  HeatSolver by_lines(metal, casting_cooling(), make_heat_forms(slab.mesh()), 1e-13);
  HeatSolver by_factor(metal, casting_cooling(), make_heat_forms(mixed), 1e-13);
  HeatField field = by_lines.uniform_field(680.0), expected = field;
  for (int i = 1; i <= 8; ++i) {
    const HeatStepInput input = input_at(0.5 * i, 0.5, depth);
    const HeatStepOutcome found = by_lines.step(field, input);
    const HeatStepOutcome factored = by_factor.step(expected, input);
    ASSERT_TRUE(found.converged && factored.converged);
    EXPECT_EQ(found.factorizations, 0);
    EXPECT_GT(factored.factorizations, 0);
    EXPECT_LE(found.balance.error, 1e-10);
    EXPECT_NEAR(found.wall_heat_flux / factored.wall_heat_flux, 1.0, 1e-10);
  }
  for (std::size_t n = 0; n < field.temperature.size(); ++n)
    EXPECT_NEAR(field.temperature[n] / expected.temperature[n], 1.0, 1e-10);
}

TEST(SolidWater, FacesHaveTheirOwnFlow) {
  const mesh::SlabMesh3D slab(quarter_slab(ElementKind::q1));
  HeatSolver solver(material::ThermalProperties(casting_alloy()), casting_cooling(),
                    make_heat_forms(slab.mesh()));
  const auto flux = [&](std::optional<double> narrow_flow) {
    HeatField field = solver.uniform_field(680.0);
    HeatStepInput input = input_at(0.5, 0.5, depth);
    input.narrow_water_flow = narrow_flow;
    return solver.step(field, input).face_heat_flux;
  };
  const auto same = flux({}), equal = flux(3e-3), dry = flux(0.0);

  EXPECT_EQ(same, equal);
  EXPECT_GT(same[1], 3.0 * dry[1]);
  // Only the metal near the edge feels it on the wide face.
  EXPECT_NEAR(same[0] / dry[0], 1.0, 0.02);
}

}  // namespace
}  // namespace dccast::thermal
