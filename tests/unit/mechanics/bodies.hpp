#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "tests/support/usual_options.hpp"
#include "tests/unit/mechanics/box_mesh.hpp"
#include "tests/verification/mechanics/fixed_body.hpp"

/// Families of elements, bodies and options the tests of mechanics share.
namespace dccast::mechanics::testing {

using verification::FixedBody;
using verification::PlaneStress;
using verification::Vector;
using verification::Vector2;

/// Families of elements that tests are typed over: sections in plane strain, billets, solids.
using PlaneFamilies =
    ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::BendingQuadrilateral>;
using SolidFamilies =
    ::testing::Types<fem::P1Tetrahedron, fem::Q1Hexahedron, fem::BendingHexahedron>;
using RoundFamilies =
    ::testing::Types<fem::AxisymmetricP1, fem::AxisymmetricQ1, fem::AxisymmetricBending>;
/// Those whose bodies may rotate, and all of them.
using FreeFamilies =
    ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::BendingQuadrilateral,
                     fem::P1Tetrahedron, fem::Q1Hexahedron, fem::BendingHexahedron>;
using AllFamilies =
    ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::BendingQuadrilateral,
                     fem::AxisymmetricP1, fem::AxisymmetricQ1, fem::AxisymmetricBending,
                     fem::P1Tetrahedron, fem::Q1Hexahedron, fem::BendingHexahedron>;

constexpr Algorithm all_algorithms[] = {Algorithm::newton, Algorithm::vnbm, Algorithm::sbm,
                                        Algorithm::nbm};
inline const char* name_of(Algorithm a) {
  constexpr const char* names[] = {"newton", "vnbm", "sbm", "nbm"};
  return names[static_cast<int>(a)];
}

/// Whether cells are divided into triangles or tetrahedra.
template <class Element>
inline constexpr bool is_simplex = Element::nodes == Element::dimension + 1;
template <class Element>
constexpr mesh::ElementKind kind_of =
    is_simplex<Element> ? mesh::ElementKind::p1 : mesh::ElementKind::q1;

template <int Dim>
using Cells = std::array<int, std::size_t(Dim)>;

/// A box of equal cells from the origin.
template <class Element, int Dim = Element::dimension>
mesh::Mesh<Dim> box(const Vector<Dim>& size, const Cells<Dim>& cells) {
  if constexpr (Dim == 2) {
    return verification::uniform_rectangle(size[0], size[1], cells[0], cells[1], kind_of<Element>);
  } else {
    return box_mesh(cells, is_simplex<Element>, [&](const Vector3& share) {
      return Vector3{share[0] * size[0], share[1] * size[1], share[2] * size[2]};
    });
  }
}

/// (node) whether it lies on the boundary.
template <int Dim>
std::vector<char> on_boundary(const mesh::Mesh<Dim>& mesh) {
  std::vector<char> on(std::size_t(mesh.nodes()), 0);
  for (const auto& patch : mesh.patches) {
    for (int n : mesh::patch_nodes(patch)) on[std::size_t(n)] = 1;
  }
  return on;
}

/// The same box with its inner nodes moved by up to a quarter of a cell.
template <class Element, int Dim = Element::dimension>
mesh::Mesh<Dim> distorted_box(const Vector<Dim>& size, const Cells<Dim>& cells) {
  mesh::Mesh<Dim> mesh = box<Element>(size, cells);
  const auto boundary = on_boundary(mesh);
  for (int n = 0; n < mesh.nodes(); ++n) {
    if (boundary[std::size_t(n)] != 0) continue;
    for (std::size_t d = 0; d < std::size_t(Dim); ++d) {
      mesh.node[std::size_t(Dim * n) + d] +=
          0.25 * size[d] / cells[d] * std::sin(3.0 * n + 2.0 * double(d) + 1.0);
    }
  }
  return mesh;
}
/// Three cells along each axis, two along the first of a solid.
template <class Element>
auto small_distorted_box() {
  if constexpr (Element::dimension == 2) {
    return distorted_box<Element>({0.3, 0.2}, {3, 3});
  } else {
    return distorted_box<Element>({0.3, 0.2, 0.25}, {2, 3, 2});
  }
}

/// A rotation by 0.7, of a solid about an oblique axis.
template <int Dim>
Eigen::Matrix<double, Dim, Dim> rotation() {
  if constexpr (Dim == 2) {
    return Eigen::Rotation2Dd(0.7).toRotationMatrix();
  } else {
    return Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
  }
}

/// The patch whose outward normal points along a coordinate axis or against it.
template <int Dim>
const mesh::Patch<Dim>& face(const mesh::Mesh<Dim>& mesh, std::size_t axis, double sign) {
  for (const auto& patch : mesh.patches) {
    if (patch.normal[axis] == sign) return patch;
  }
  throw std::logic_error("a box has no such face");
}

/// Coordinate of the centroid of an element along the last axis [m].
template <int Dim>
double height_of(const mesh::Mesh<Dim>& mesh, int element) {
  double height = 0.0;
  for (int i = 0; i < mesh.nodes_per_element; ++i) {
    height += mesh.point(mesh.nodes_of(element)[i])[Dim - 1] / mesh.nodes_per_element;
  }
  return height;
}

/// Holds every node of the boundary at a displacement.
template <class Element, class Displacement>
void hold_boundary(FixedBody<Element>& body, Displacement&& displacement) {
  const auto boundary = on_boundary(body.mesh);
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    if (boundary[std::size_t(n)] != 0) body.fix(n, std::apply(displacement, body.place(n)));
  }
}
/// Holds the nodes on the lower end of a coordinate along it.
template <class Element>
void hold_low_end(FixedBody<Element>& body, int coordinate) {
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    if (body.mesh.point(n)[coordinate] == 0.0) body.fix(n, coordinate, 0.0);
  }
}
/// Holds a body on its planes of symmetry, which are the lower ends of all coordinates but the
/// last.
template <class Element>
void hold_symmetry(FixedBody<Element>& body) {
  for (int d = 0; d + 1 < Element::dimension; ++d) hold_low_end(body, d);
}

inline Options tight(double tolerance = 1e-14) {
  return dccast::testing::usual_options(tolerance);
}

template <int Dim>
SymmetricTensor<Dim> difference(SymmetricTensor<Dim> a, const SymmetricTensor<Dim>& b) {
  return a.add(-1.0, b);
}
/// Norm of a difference over that of the second.
inline double relative_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += (a[i] - b[i]) * (a[i] - b[i]), scale += b[i] * b[i];
  }
  return std::sqrt(sum / scale);
}
inline double largest_of(const std::vector<double>& values) {
  double largest = 0.0;
  for (double v : values) largest = std::max(largest, std::abs(v));
  return largest;
}

}  // namespace dccast::mechanics::testing
