#include "core/fem/element_geometry.hpp"

#include <gtest/gtest.h>

namespace dccast::fem {
namespace {

template <int Dim>
mesh::Mesh<Dim> one_element(std::vector<double> node) {
  mesh::Mesh<Dim> mesh;
  mesh.node = std::move(node);
  mesh.nodes_per_element = mesh.nodes();
  for (int n = 0; n < mesh.nodes(); ++n) mesh.element_node.push_back(n);
  return mesh;
}

const auto triangle = one_element<2>({0.1, 0.2, 1.3, 0.4, 0.5, 1.7});
const auto quadrilateral = one_element<2>({0.0, 0.0, 2.0, 0.3, 1.7, 1.9, -0.2, 1.1});
const auto tetrahedron =
    one_element<3>({0.1, 0.2, 0.0, 1.3, 0.4, 0.1, 0.5, 1.7, -0.1, 0.4, 0.5, 1.1});
const auto hexahedron =
    one_element<3>({0.0, 0.0, 0.0, 1.1, 0.1, -0.1, 1.0, 1.2, 0.1, 0.1,  0.9, 0.0,
                    0.0, 0.1, 1.0, 1.0, 0.0, 1.1,  1.2, 1.1, 1.0, -0.1, 1.0, 0.9});

double polygon_area(const mesh::Mesh2D& mesh) {
  double twice = 0.0;
  for (int n = 0; n < mesh.nodes(); ++n) {
    const double *a = mesh.point(n), *b = mesh.point((n + 1) % mesh.nodes());
    twice += a[0] * b[1] - b[0] * a[1];
  }
  return 0.5 * twice;
}

/// The gradient of a linear field comes out at every point and in the mean.
template <class Element>
void expect_linear_fields_to_be_exact(const mesh::Mesh<Element::dimension>& mesh) {
  ElementGeometry<Element> geometry;
  geometry.update(mesh);
  const auto& cell = geometry.cell(0);
  for (std::size_t d = 0; d < std::size_t(Element::dimension); ++d) {
    for (std::size_t a = 0; a < std::size_t(Element::dimension); ++a) {
      const double exact = a == d ? 1.0 : 0.0;  // gradient of the coordinate d
      double mean = 0.0;
      for (std::size_t i = 0; i < std::size_t(Element::nodes); ++i) {
        mean += cell.mean_gradient[i][a] * mesh.point(int(i))[d];
      }
      EXPECT_NEAR(mean, exact, 1e-14);
      for (const auto& point : cell.point) {
        double gradient = 0.0;
        for (std::size_t i = 0; i < std::size_t(Element::nodes); ++i) {
          gradient += point.gradient[i][a] * mesh.point(int(i))[d];
        }
        EXPECT_NEAR(gradient, exact, 1e-14);
      }
    }
  }
  double volume = 0.0;
  for (const auto& point : cell.point) {
    EXPECT_GT(point.weight, 0.0);
    volume += point.weight;
  }
  EXPECT_DOUBLE_EQ(cell.volume, volume);
}

TEST(ElementGeometry, LinearFieldsAreExact) {
  expect_linear_fields_to_be_exact<P1Triangle>(triangle);
  expect_linear_fields_to_be_exact<Q1Quadrilateral>(quadrilateral);
  expect_linear_fields_to_be_exact<P1Tetrahedron>(tetrahedron);
  expect_linear_fields_to_be_exact<Q1Hexahedron>(hexahedron);
}

TEST(ElementGeometry, VolumesAreThoseOfThePolygons) {
  ElementGeometry<P1Triangle> flat;
  flat.update(triangle);
  EXPECT_DOUBLE_EQ(flat.cell(0).volume, polygon_area(triangle));
  ElementGeometry<Q1Quadrilateral> square;
  square.update(quadrilateral);
  EXPECT_DOUBLE_EQ(square.cell(0).volume, polygon_area(quadrilateral));
}

/// Pappus: a section turned by one radian sweeps its area times the radius of its centroid.
TEST(ElementGeometry, AxisymmetricVolumesArePerRadian) {
  ElementGeometry<AxisymmetricP1> flat;
  flat.update(triangle);
  EXPECT_DOUBLE_EQ(flat.cell(0).volume, polygon_area(triangle) * (0.1 + 1.3 + 0.5) / 3.0);
  const auto rectangle = one_element<2>({0.5, 0.0, 2.0, 0.0, 2.0, 1.0, 0.5, 1.0});
  ElementGeometry<AxisymmetricQ1> square;
  square.update(rectangle);
  EXPECT_DOUBLE_EQ(square.cell(0).volume, 0.5 * (2.0 * 2.0 - 0.5 * 0.5));
}

/// u = r dilates by 2: by 1 across and by 1 around, at every point and in the mean.
TEST(ElementGeometry, AxisymmetricElementsHaveAHoopGradient) {
  const auto check = []<class Element>(const ElementGeometry<Element>& geometry,
                                       const mesh::Mesh2D& mesh) {
    const auto& cell = geometry.cell(0);
    double mean = 0.0;
    for (std::size_t i = 0; i < std::size_t(Element::nodes); ++i) {
      mean += cell.mean_gradient[i][0] * mesh.point(int(i))[0];
    }
    EXPECT_NEAR(mean, 2.0, 1e-14);
    for (const auto& point : cell.point) {
      double hoop = 0.0;
      for (std::size_t i = 0; i < std::size_t(Element::nodes); ++i) {
        hoop += point.hoop[i] * mesh.point(int(i))[0];
      }
      EXPECT_NEAR(hoop, 1.0, 1e-14);
    }
  };
  ElementGeometry<AxisymmetricP1> flat;
  flat.update(triangle);
  check(flat, triangle);
  const auto skewed = one_element<2>({0.0, 0.0, 2.0, 0.3, 1.7, 1.9, 0.2, 1.1});
  ElementGeometry<AxisymmetricQ1> square;
  square.update(skewed);
  check(square, skewed);
}

TEST(ElementGeometry, VolumeOfASkewedBoxIsItsDeterminant) {
  mesh::Mesh<3> box = one_element<3>({});
  for (const auto& c : detail::corner) {
    const double a = 0.5 * (c[0] + 1), b = 0.5 * (c[1] + 1), d = 0.5 * (c[2] + 1);
    box.node.insert(box.node.end(), {2.0 * a + 0.3 * b, 1.5 * b + 0.2 * d, 0.7 * d + 0.1 * a});
  }
  box.nodes_per_element = 8;
  box.element_node = {0, 1, 2, 3, 4, 5, 6, 7};
  ElementGeometry<Q1Hexahedron> geometry;
  geometry.update(box);
  EXPECT_NEAR(geometry.cell(0).volume, 2.0 * 1.5 * 0.7 + 0.3 * 0.2 * 0.1, 1e-14);
}

/// Only the elements from `first` on are computed again.
TEST(ElementGeometry, UpdatesFromTheFirstMovedElement) {
  mesh::Mesh2D two;
  two.node = {0, 0, 1, 0, 1, 1, 0, 1};
  two.nodes_per_element = 3;
  two.element_node = {0, 1, 2, 0, 2, 3};
  ElementGeometry<P1Triangle> geometry;
  geometry.update(two);
  two.node[4] = two.node[5] = 2.0;
  geometry.update(two, 1);
  EXPECT_DOUBLE_EQ(geometry.cell(0).volume, 0.5);
  EXPECT_DOUBLE_EQ(geometry.cell(1).volume, 1.0);
}

}  // namespace
}  // namespace dccast::fem
