#include "core/fem/point_location.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "core/mesh/slab_mesh.hpp"
#include "tests/support/print_kinds.hpp"
#include "tests/support/quarter_section.hpp"

namespace dccast::fem {
namespace {

using mesh::ElementKind;

mesh::SectionSpec section(mesh::SectionKind kind, ElementKind element) {
  // A convex mould: the cells of its plan are no rectangles.
  const Curve opening(Abscissa::distance, {0.0, 0.1, 0.28}, {0.15, 0.145, 0.12});
  mesh::SectionSpec spec =
      testing::quarter_section(element, {0.28, opening, 0.10}, {7, 3, 4, 0.012, 0.02, 0.010});
  spec.kind = kind;
  return spec;
}

/// A displacement that is linear in the coordinates, (node, Dim).
template <int Dim>
double linear(const double* x, int component) {
  double value = 1.0 + component;
  for (int d = 0; d < Dim; ++d) value += (2.0 * component - 3.0 * d + 0.5) * x[d];
  return value;
}

template <int Dim>
std::vector<double> linear_field(const mesh::Mesh<Dim>& mesh) {
  std::vector<double> u;
  for (int n = 0; n < mesh.nodes(); ++n)
    for (int d = 0; d < Dim; ++d) u.push_back(linear<Dim>(mesh.point(n), d));
  return u;
}

template <int Dim>
void expect_exact(const mesh::Mesh<Dim>& mesh, const std::array<double, std::size_t(Dim)>& point) {
  const auto place = locate<Dim>(mesh, point);
  ASSERT_TRUE(place) << point[0] << ", " << point[1];
  const auto u = linear_field(mesh);
  for (int d = 0; d < Dim; ++d)
    EXPECT_NEAR(interpolate<Dim>(mesh, *place, u, Dim, d), linear<Dim>(point.data(), d), 1e-13);
}

class PointLocation : public ::testing::TestWithParam<ElementKind> {};

TEST_P(PointLocation, InterpolatesALinearFieldExactlyInAPlane) {
  const mesh::SlabMesh2D slab(section(mesh::SectionKind::plane_strain, GetParam()));
  for (int i = 0; i <= 20; ++i)
    for (int j = 0; j <= 20; ++j) expect_exact<2>(slab.mesh(), {0.28 * i / 20.0, 0.10 * j / 20.0});
}

TEST_P(PointLocation, InterpolatesALinearFieldExactlyInASolid) {
  const mesh::SlabMesh3D slab(section(mesh::SectionKind::quarter_slab, GetParam()));
  for (int i = 0; i <= 6; ++i)
    for (int j = 0; j <= 6; ++j)
      for (int k = 0; k <= 5; ++k)
        expect_exact<3>(slab.mesh(), {0.28 * i / 6.0, 0.12 * j / 6.0, 0.10 * k / 5.0});
}

TEST_P(PointLocation, FindsEveryNodeAsItself) {
  const mesh::SlabMesh3D slab(section(mesh::SectionKind::quarter_slab, GetParam()));
  std::vector<double> one(std::size_t(slab.mesh().nodes()), 0.0);
  for (int n = 0; n < slab.mesh().nodes(); ++n) {
    const double* x = slab.mesh().point(n);
    one[std::size_t(n)] = 1.0;
    const auto place = locate<3>(slab.mesh(), {x[0], x[1], x[2]});
    ASSERT_TRUE(place) << n;
    EXPECT_NEAR(interpolate<3>(slab.mesh(), *place, one), 1.0, 1e-12);
    one[std::size_t(n)] = 0.0;
  }
}

TEST_P(PointLocation, FindsNothingOutside) {
  const mesh::SlabMesh2D plane(section(mesh::SectionKind::plane_strain, GetParam()));
  for (const std::array<double, 2>& point :
       {std::array{0.2801, 0.05}, {-0.0001, 0.05}, {0.1, 0.1001}, {0.1, -0.0001}})
    EXPECT_FALSE(locate<2>(plane.mesh(), point)) << point[0] << ", " << point[1];
  const mesh::SlabMesh3D solid(section(mesh::SectionKind::quarter_slab, GetParam()));
  for (const std::array<double, 3>& point :
       {std::array{0.2801, 0.05, 0.05}, {0.27, 0.1235, 0.05}, {0.1, 0.05, 0.1001}})
    EXPECT_FALSE(locate<3>(solid.mesh(), point)) << point[0] << ", " << point[1];
}

INSTANTIATE_TEST_SUITE_P(Elements, PointLocation,
                         ::testing::Values(ElementKind::p1, ElementKind::q1));

/// A quadrilateral that is no rectangle: the bilinear map is inverted by Newton.
TEST(PointLocationInOneCell, InvertsTheMapOfASkewedQuadrilateral) {
  mesh::Mesh2D skewed;
  skewed.node = {0.0, 0.0, 2.0, 0.3, 1.7, 1.9, -0.2, 1.1};
  skewed.nodes_per_element = 4;
  skewed.element_node = {0, 1, 2, 3};
  const auto place = locate<2>(skewed, {0.9, 0.8});
  ASSERT_TRUE(place);
  EXPECT_NEAR(interpolate<2>(skewed, *place, skewed.node, 2, 0), 0.9, 1e-12);
  EXPECT_NEAR(interpolate<2>(skewed, *place, skewed.node, 2, 1), 0.8, 1e-12);
  EXPECT_FALSE(locate<2>(skewed, {1.9, 1.0}));
}

/// A hexahedron of which no face is plane.
TEST(PointLocationInOneCell, InvertsTheMapOfASkewedHexahedron) {
  mesh::Mesh3D skewed;
  skewed.node = {0.0, 0.0, 0.0, 2.0, 0.3, -0.2, 1.7, 1.9, 0.1, -0.2, 1.1, 0.0,
                 0.1, 0.0, 1.0, 1.9, 0.1, 1.2,  1.8, 1.7, 0.9, 0.0,  1.2, 1.1};
  skewed.nodes_per_element = 8;
  skewed.element_node = {0, 1, 2, 3, 4, 5, 6, 7};
  const auto place = locate<3>(skewed, {0.9, 0.8, 0.4});
  ASSERT_TRUE(place);
  for (int d = 0; d < 3; ++d)
    EXPECT_NEAR(interpolate<3>(skewed, *place, skewed.node, 3, d),
                (std::array{0.9, 0.8, 0.4})[std::size_t(d)], 1e-12);
  EXPECT_FALSE(locate<3>(skewed, {1.9, 1.0, 1.15}));
}

}  // namespace
}  // namespace dccast::fem
