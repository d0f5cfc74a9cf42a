#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/fem/element.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::fem {

/// Integrals by node of a facet [m^(Dim-1)], axisymmetric [m2/rad]: two for an edge, four for a
/// face; the last one of a triangle is zero.
template <int Dim>
using FacetShares = std::array<double, Dim == 2 ? 2 : 4>;

/// Integrals of the shape functions of an edge [m].
inline FacetShares<2> facet_shares(const mesh::Mesh<2>& mesh, const mesh::Facet<2>& facet) {
  const double *a = mesh.point(facet.node[0]), *b = mesh.point(facet.node[1]);
  const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
  return {0.5 * length, 0.5 * length};
}

/// Axisymmetric: times the radius, coordinate 0 [m2/rad].
inline FacetShares<2> facet_shares_per_radian(const mesh::Mesh<2>& mesh,
                                              const mesh::Facet<2>& facet) {
  const double *a = mesh.point(facet.node[0]), *b = mesh.point(facet.node[1]);
  const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
  return {length * (2.0 * a[0] + b[0]) / 6.0, length * (a[0] + 2.0 * b[0]) / 6.0};
}

namespace detail {
inline Eigen::Vector3d corner_of(const mesh::Mesh<3>& mesh, const mesh::Facet<3>& facet,
                                 std::size_t i) {
  return Eigen::Map<const Eigen::Vector3d>(mesh.point(facet.node[i]));
}

/// Normal vector of a triangle with twice its area as length [m2].
inline Eigen::Vector3d doubled_area(const mesh::Mesh<3>& mesh, const mesh::Facet<3>& facet) {
  const Eigen::Vector3d a = corner_of(mesh, facet, 0);
  return (corner_of(mesh, facet, 1) - a).cross(corner_of(mesh, facet, 2) - a);
}
}  // namespace detail

/// Integrals of the shape functions of a triangle or of a quadrilateral, which need not be plane
/// [m2]; the latter by 2 x 2 Gauss points.
inline FacetShares<3> facet_shares(const mesh::Mesh<3>& mesh, const mesh::Facet<3>& facet) {
  if (facet.nodes == 3) {
    const double third = detail::doubled_area(mesh, facet).norm() / 6.0;
    return {third, third, third, 0.0};
  }
  FacetShares<3> shares{};
  for (const auto& p : Q1Quadrilateral::point) {
    const auto shape = Q1Quadrilateral::shape(p);
    const auto gradient = Q1Quadrilateral::shape_gradient(p);
    Eigen::Vector3d along = Eigen::Vector3d::Zero(), across = along;
    for (std::size_t i = 0; i < 4; ++i) {
      along += gradient[i][0] * detail::corner_of(mesh, facet, i);
      across += gradient[i][1] * detail::corner_of(mesh, facet, i);
    }
    const double area = along.cross(across).norm();
    for (std::size_t i = 0; i < 4; ++i) shares[i] += shape[i] * area;
  }
  return shares;
}

/// Integrals of the shape functions of a facet of an element [m^(Dim-1)], axisymmetric: [m2/rad].
template <class Element>
FacetShares<Element::dimension> facet_shares_of(const mesh::Mesh<Element::dimension>& mesh,
                                                const mesh::Facet<Element::dimension>& facet) {
  if constexpr (is_axisymmetric<Element>) {
    return facet_shares_per_radian(mesh, facet);
  } else {
    return facet_shares(mesh, facet);
  }
}

}  // namespace dccast::fem
