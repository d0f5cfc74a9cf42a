#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "core/mesh/base.hpp"
#include "core/mesh/extrusion.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "tests/support/print_kinds.hpp"
#include "tests/support/quarter_section.hpp"

namespace dccast::mesh {
namespace {

constexpr double length = 0.66, thickness = 0.285, depth = 0.07;

SectionSpec quarter(ElementKind element) {
  SectionSpec spec = testing::quarter_section(element, {length, Curve(thickness), depth},
                                              {6, 4, 3, 0.03, 0.02, 0.01});
  spec.growth_cell = 0.012;
  return spec;
}

/// The opening of figure 3 of the paper in its kind: 20 mm more at the middle, straight pieces.
SectionSpec convex(ElementKind element) {
  SectionSpec spec = quarter(element);
  spec.half_thickness = Curve(Abscissa::distance, {0.0, 0.2, 0.5, length},
                              {thickness + 0.02, thickness + 0.02, thickness + 0.008, thickness});
  return spec;
}

using Vector = std::array<double, 3>;

Vector between(const double* a, const double* b) {
  return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
}
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Area times outward normal of a plane facet.
Vector area_of(const Mesh3D& mesh, const Facet<3>& facet) {
  const double *a = mesh.point(facet.node[0]), *b = mesh.point(facet.node[1]),
               *c = mesh.point(facet.node[2]),
               *d = facet.nodes == 4 ? mesh.point(facet.node[3]) : a;
  Vector area = cross(between(a, c), between(b, d));
  for (double& component : area) component *= 0.5;
  return area;
}

double volume_of(const Mesh3D& mesh, int e) {
  const int* n = mesh.nodes_of(e);
  const auto tetrahedron = [&](int a, int b, int c, int d) {
    const double* o = mesh.point(n[a]);
    return dot(cross(between(o, mesh.point(n[b])), between(o, mesh.point(n[c]))),
               between(o, mesh.point(n[d]))) /
           6.0;
  };
  if (mesh.nodes_per_element == 4) return tetrahedron(0, 1, 2, 3);
  // The six tetrahedra around the diagonal from 0 to 6.
  return tetrahedron(0, 1, 2, 6) + tetrahedron(0, 5, 1, 6) + tetrahedron(0, 2, 3, 6) +
         tetrahedron(0, 3, 7, 6) + tetrahedron(0, 4, 5, 6) + tetrahedron(0, 7, 4, 6);
}

/// What an arc of chords cuts off a corner: the kite up to its two ends without the triangles
/// between centre and chords.
double cut_off(const SectionSpec& spec) {
  if (spec.corner_radius == 0.0) return 0.0;
  const CornerArc arc = corner_arc(spec);
  double chords = 0.0;
  for (const int cells : corner_cells(spec))
    chords += 0.5 * cells * std::sin(0.5 * arc.angle / cells);
  return spec.corner_radius * spec.corner_radius * (std::tan(0.5 * arc.angle) - chords);
}

double plan_area(const SectionSpec& spec) {
  const double square = spec.half_thickness.constant() ? length * thickness
                                                       : spec.half_thickness.integral(0.0, length);
  return square - cut_off(spec);
}

class QuarterSlabMesh : public ::testing::TestWithParam<std::tuple<ElementKind, bool, double>> {
protected:
  SectionSpec spec() const {
    const auto [element, is_convex, radius] = GetParam();
    SectionSpec spec = is_convex ? convex(element) : quarter(element);
    spec.corner_radius = radius;
    return spec;
  }
};

TEST_P(QuarterSlabMesh, FillsThePlanWithPositiveElements) {
  const SlabMesh3D slab(spec());
  double volume = 0.0;
  for (int e = 0; e < slab.mesh().elements(); ++e) {
    ASSERT_GT(volume_of(slab.mesh(), e), 0.0) << "element " << e;
    volume += volume_of(slab.mesh(), e);
  }
  EXPECT_NEAR(volume, plan_area(spec()) * depth, 1e-14);
  EXPECT_EQ(slab.mesh().elements(), slab.rows() * slab.elements_per_row());
}

/// Each facet is one of the element it names, no two elements have it, and by Gauss the facets
/// enclose the volume.
TEST_P(QuarterSlabMesh, PatchesCloseTheBoundaryWithOutwardNormals) {
  SlabMesh3D slab(spec());
  slab.grow_to(depth + 0.031);
  const Mesh3D& mesh = slab.mesh();
  std::set<std::set<int>> seen;
  Vector closed{};
  double volume = 0.0;
  for (const auto& patch : mesh.patches) {
    for (const auto& facet : patch.facets) {
      const std::set<int> nodes(facet.node.begin(), facet.node.begin() + facet.nodes);
      EXPECT_TRUE(seen.insert(nodes).second);
      const int* of_element = mesh.nodes_of(facet.element);
      for (const int n : nodes)
        EXPECT_EQ(std::count(of_element, of_element + mesh.nodes_per_element, n), 1);
      const Vector area = area_of(mesh, facet);
      EXPECT_NEAR(dot(area, patch.normal), std::sqrt(dot(area, area)), 1e-12) << patch.name;
      for (std::size_t d = 0; d < 3; ++d) closed[d] += area[d];
      const double* at = mesh.point(facet.node[0]);
      volume += dot(area, {at[0], at[1], at[2]}) / 3.0;
    }
  }
  for (const double component : closed) EXPECT_NEAR(component, 0.0, 1e-14);
  EXPECT_NEAR(volume, plan_area(spec()) * slab.level(), 1e-13);
}

TEST_P(QuarterSlabMesh, GrowthOnlyAppends) {
  SlabMesh3D slab(spec());
  const Mesh3D before = slab.mesh();
  const auto between = slab.grow_to(depth + 0.05);
  EXPECT_FALSE(between.empty());
  const Mesh3D& after = slab.mesh();
  ASSERT_GT(after.elements(), before.elements());
  EXPECT_TRUE(std::equal(before.element_node.begin(), before.element_node.end(),
                         after.element_node.begin()));
  const std::size_t kept = before.node.size() - 3 * std::size_t(slab.nodes_per_row());
  EXPECT_TRUE(
      std::equal(before.node.begin(), before.node.begin() + long(kept), after.node.begin()));

  SlabMesh3D restored(spec());
  restored.restore(slab.row_heights());
  EXPECT_EQ(restored.mesh().node, after.node);
  EXPECT_EQ(restored.mesh().element_node, after.element_node);
}

INSTANTIATE_TEST_SUITE_P(ElementsAndPlans, QuarterSlabMesh,
                         ::testing::Combine(::testing::Values(ElementKind::p1, ElementKind::q1,
                                                              ElementKind::q1_bending),
                                            ::testing::Bool(), ::testing::Values(0.0, 0.06)));

TEST(QuarterSlabMesh, HasAWallForEachStraightPieceOfTheMould) {
  const SlabMesh3D slab(convex(ElementKind::q1));
  ASSERT_NE(slab.mesh().find("side_y_3"), nullptr);
  EXPECT_EQ(slab.mesh().find("side_y_4"), nullptr);
  EXPECT_NEAR(slab.mesh().find("side_y_2")->normal[0], 0.012 / std::hypot(0.3, 0.012), 1e-12);
  EXPECT_EQ(SlabMesh3D(quarter(ElementKind::q1)).mesh().find("side_y_2"), nullptr);
}

SectionSpec rounded(double radius) {
  SectionSpec spec = convex(ElementKind::q1_bending);
  spec.corner_radius = radius;
  spec.columns = 12;
  spec.layers = 8;
  return spec;
}

double turn(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::acos(std::min(1.0, dot(a, b))) * 180.0 / 3.14159265358979323846;
}

TEST(RoundedCorner, TouchesBothFacesAndStaysOnItsCircle) {
  const SectionSpec spec = rounded(0.06);
  const CornerArc arc = corner_arc(spec);
  EXPECT_NEAR(arc.on_narrow_face()[0], length, 1e-12);
  EXPECT_NEAR(arc.on_wide_face()[1], spec.half_thickness(arc.on_wide_face()[0]), 1e-12);

  const Base<3> plan = base_of<3>(spec);
  int on_arc = 0;
  for (const auto& wall : plan.walls) {
    if (!wall.name.starts_with("side_corner")) continue;
    for (const auto& piece : wall.pieces)
      for (const int k : {piece.side, (piece.side + 1) % 4}) {
        const double* at =
            &plan.node[2 * std::size_t(plan.cell_node[std::size_t(4 * piece.cell + k)])];
        const double x = at[0] - arc.centre[0], y = at[1] - arc.centre[1];
        EXPECT_NEAR(std::hypot(x, y), 0.06, 1e-12);
        EXPECT_GT(x * wall.normal[0] + y * wall.normal[1], 0.0) << "outward";
        ++on_arc;
      }
  }
  const auto cells = corner_cells(spec);
  EXPECT_EQ(on_arc, 2 * (cells[0] + cells[1]));
}

TEST(RoundedCorner, TurnsByLessThan30DegreesFromChordToChord) {
  for (const double radius : {0.06, 0.09, 0.12}) {
    const Base<3> plan = base_of<3>(rounded(radius));
    std::vector<std::array<double, 3>> around;
    for (const auto& wall : plan.walls)
      if (wall.name.starts_with("side_y") || wall.name.starts_with("side_corner"))
        around.push_back(wall.normal);
    around.push_back({1.0, 0.0, 0.0});
    for (std::size_t i = 0; i + 1 < around.size(); ++i)
      EXPECT_LT(turn(around[i], around[i + 1]), 30.0) << radius;
  }
}

TEST(RoundedCorner, ManyChordsCutOffWhatACircleDoes) {
  SectionSpec spec = rounded(0.06);
  spec.half_thickness = Curve(thickness);
  spec.refinement = 16;
  const double circle = 0.06 * 0.06 * (1.0 - std::atan(1.0));
  EXPECT_NEAR(cut_off(spec), circle, 2e-3 * circle);
  const Base<3> plan = base_of<3>(spec);
  EXPECT_NEAR(reach_of(plan, 0.3), thickness, 1e-12);
  EXPECT_NEAR(reach_of(plan, length), thickness - 0.06, 1e-12);
  EXPECT_NEAR(reach_of(plan, length - 0.03), thickness - 0.06 * (1.0 - std::sqrt(0.75)), 1e-5);
}

TEST(QuarterSlabMesh, IsFoundToBeExtruded) {
  SlabMesh<3> slab(convex(ElementKind::q1_bending));
  slab.grow_to(0.1);
  const auto rows = extrusion_of(slab.mesh());
  ASSERT_TRUE(rows.has_value());
  EXPECT_EQ(rows->lines, slab.nodes_per_row());
  EXPECT_EQ(rows->height, slab.row_heights());
  EXPECT_EQ(rows->cell.size(), 4u * 6u * 4u);
}

TEST(QuarterSlabMesh, IsNoExtrusionOfHexahedraWhereANodeHasMovedOrOfTetrahedra) {
  Mesh<3> bent = SlabMesh<3>(quarter(ElementKind::q1)).mesh();
  bent.node[bent.node.size() - 3] += 1e-3;
  EXPECT_FALSE(extrusion_of(bent).has_value());
  EXPECT_FALSE(extrusion_of(SlabMesh<3>(quarter(ElementKind::p1)).mesh()).has_value());
}

}  // namespace
}  // namespace dccast::mesh
