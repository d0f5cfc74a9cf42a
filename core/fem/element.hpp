#pragma once

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/mesh/section_spec.hpp"

namespace dccast::fem {

/// An element family is a struct with its dimension, its numbers of nodes and quadrature points,
/// the points and weights on the reference cell, and the shape functions there. Everything else
/// (mean gradients, assembly, material) is templated on these.
///
/// Units: reference coordinates, weights on the reference cell and shape functions [1].

/// Linear triangle, one point: the paper's element (section 4.1).
struct P1Triangle {
  /// One point at the centroid integrates the constant strain exactly.
  static constexpr int dimension = 2, nodes = 3, points = 1;
  static constexpr std::array<std::array<double, 2>, 1> point{{{1.0 / 3.0, 1.0 / 3.0}}};
  static constexpr std::array<double, 1> weight{0.5};

  /// Values of the shape functions at a reference point, by node; they sum to 1.
  static std::array<double, 3> shape(const std::array<double, 2>& p) {
    return {1.0 - p[0] - p[1], p[0], p[1]};
  }
  /// Derivatives of the shape functions by the reference coordinates, by node; here constant.
  static std::array<std::array<double, 2>, 3> shape_gradient(const std::array<double, 2>&) {
    return {{{-1.0, -1.0}, {1.0, 0.0}, {0.0, 1.0}}};
  }
};

/// Linear tetrahedron, one point: the paper's element in three dimensions.
struct P1Tetrahedron {
  /// One point at the centroid integrates the constant strain exactly.
  static constexpr int dimension = 3, nodes = 4, points = 1;
  static constexpr std::array<std::array<double, 3>, 1> point{{{0.25, 0.25, 0.25}}};
  static constexpr std::array<double, 1> weight{1.0 / 6.0};

  /// Barycentric coordinates of a reference point, by node.
  static std::array<double, 4> shape(const std::array<double, 3>& p) {
    return {1.0 - p[0] - p[1] - p[2], p[0], p[1], p[2]};
  }
  /// Derivatives of the shape functions by the reference coordinates, by node; here constant.
  static std::array<std::array<double, 3>, 4> shape_gradient(const std::array<double, 3>&) {
    return {{{-1.0, -1.0, -1.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  }
};

namespace detail {
inline constexpr double gauss = 0.57735026918962576451;  ///< [1] 1/sqrt(3)
/// Reference coordinates of the nodes of a hexahedron [1]; the first four are those of a
/// quadrilateral.
inline constexpr std::array<std::array<double, 3>, 8> corner{{{-1, -1, -1},
                                                              {1, -1, -1},
                                                              {1, 1, -1},
                                                              {-1, 1, -1},
                                                              {-1, -1, 1},
                                                              {1, -1, 1},
                                                              {1, 1, 1},
                                                              {-1, 1, 1}}};
}  // namespace detail

/// Bilinear quadrilateral and trilinear hexahedron with 2^Dim Gauss points. Used with the mean of
/// the dilatation over the element (B-bar; Hughes 1980) they do not lock.
template <int Dim>
struct Q1 {
  /// Two Gauss points in each direction, exact for polynomials of degree three.
  static constexpr int dimension = Dim, nodes = 1 << Dim, points = 1 << Dim;

  /// The points have the signs of the nodes and stand in their order.
  static constexpr std::array<std::array<double, Dim>, points> gauss_points() {
    std::array<std::array<double, Dim>, points> p{};
    for (std::size_t i = 0; i < points; ++i) {
      for (std::size_t d = 0; d < Dim; ++d) p[i][d] = detail::gauss * detail::corner[i][d];
    }
    return p;
  }
  static constexpr std::array<double, points> unit_weights() {
    std::array<double, points> w{};
    for (double& value : w) value = 1.0;
    return w;
  }
  static constexpr std::array<std::array<double, Dim>, points> point = gauss_points();
  static constexpr std::array<double, points> weight = unit_weights();

  /// Products of linear functions, 1 at their own node: N_i = prod_d (1 + x_i,d p_d) / 2.
  static std::array<double, nodes> shape(const std::array<double, Dim>& p) {
    std::array<double, nodes> n{};
    for (std::size_t i = 0; i < nodes; ++i) {
      n[i] = 1.0;
      for (std::size_t d = 0; d < Dim; ++d) n[i] *= 0.5 * (1.0 + detail::corner[i][d] * p[d]);
    }
    return n;
  }
  /// Derivatives of the shape functions by the reference coordinates, by node.
  static std::array<std::array<double, Dim>, nodes> shape_gradient(
      const std::array<double, Dim>& p) {
    std::array<std::array<double, Dim>, nodes> g{};
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t d = 0; d < Dim; ++d) {
        g[i][d] = 0.5 * detail::corner[i][d];
        for (std::size_t o = 0; o < Dim; ++o) {
          if (o != d) g[i][d] *= 0.5 * (1.0 + detail::corner[i][o] * p[o]);
        }
      }
    }
    return g;
  }
};

using Q1Quadrilateral = Q1<2>;
using Q1Hexahedron = Q1<3>;

/// The bilinear quadrilateral with assumed strain, which avoids both volumetric and shear locking
/// (Belytschko and Bindeman 1991, element OI, here on the covariant axes of the cell). The strain
/// is the sum of its mean over the element and two bending modes: a stretch along one axis of the
/// cell that varies linearly across it, with the opposite transverse strain, which preserves the
/// volume, and no shear. In bending, Q1 has a parasitic shear that grows with the aspect ratio of
/// the cell.
struct BendingQuadrilateral : Q1Quadrilateral {};

/// The trilinear hexahedron with assumed strain: the same idea in three dimensions. Besides its
/// mean, the strain has the bending and twisting modes of three plates, one normal to each axis of
/// the cell: stretches and shear in the plane of the other two axes, linear through the thickness,
/// with the opposite strain through the thickness and no transverse shear. Three bilinear stretches
/// complete it, so that there are no zero-energy modes. docs/developers/decisions.md explains the
/// choice.
struct BendingHexahedron : Q1Hexahedron {};

/// A plane element rotated about the axis where coordinate 0, the radius, is zero. Its integrals
/// include the radius but not 2 pi: forces are per radian. A radial displacement causes a hoop
/// strain, the zz component.
template <class Plane>
struct Axisymmetric : Plane {};

/// The elements of a billet's section.
using AxisymmetricP1 = Axisymmetric<P1Triangle>;
using AxisymmetricQ1 = Axisymmetric<Q1Quadrilateral>;
using AxisymmetricBending = Axisymmetric<BendingQuadrilateral>;

/// Whether the element is an Axisymmetric one.
template <class Element>
inline constexpr bool is_axisymmetric = false;
template <class Plane>
inline constexpr bool is_axisymmetric<Axisymmetric<Plane>> = true;

/// Whether the strain of the element consists of its mean and bending modes, see
/// BendingQuadrilateral.
template <class Element>
inline constexpr bool has_bending_modes = false;
template <>
inline constexpr bool has_bending_modes<BendingQuadrilateral> = true;
template <>
inline constexpr bool has_bending_modes<AxisymmetricBending> = true;
template <>
inline constexpr bool has_bending_modes<BendingHexahedron> = true;

/// Calls `use.operator()<Element>()` with the element type of a section. This is the only place
/// where the element of a case is turned into a type.
template <class Use>
decltype(auto) with_element(mesh::ElementKind element, mesh::SectionKind section, Use&& use) {
  const bool round = section == mesh::SectionKind::axisymmetric;

  switch (element) {
    case mesh::ElementKind::p1:
      return round ? use.template operator()<AxisymmetricP1>()
                   : use.template operator()<P1Triangle>();

    case mesh::ElementKind::q1:
      return round ? use.template operator()<AxisymmetricQ1>()
                   : use.template operator()<Q1Quadrilateral>();

    case mesh::ElementKind::q1_bending:
      return round ? use.template operator()<AxisymmetricBending>()
                   : use.template operator()<BendingQuadrilateral>();
  }

  throw std::logic_error("with_element: element kind without a type");
}

/// Calls `use.operator()<Element>()` with the element type of a solid: tetrahedra or hexahedra.
template <class Use>
decltype(auto) with_solid_element(mesh::ElementKind element, Use&& use) {
  switch (element) {
    case mesh::ElementKind::p1:
      return use.template operator()<P1Tetrahedron>();
    case mesh::ElementKind::q1:
      return use.template operator()<Q1Hexahedron>();
    case mesh::ElementKind::q1_bending:
      return use.template operator()<BendingHexahedron>();
  }
  throw std::logic_error("with_solid_element: element kind without a type");
}

/// Calls `use.operator()<Element>()` with the linear element of cells with a number of nodes, which
/// interpolates coordinates, temperatures and displacements in every family.
template <int Dim, class Use>
decltype(auto) with_linear_element(int nodes, Use&& use) {
  if constexpr (Dim == 2) {
    if (nodes == P1Triangle::nodes) return use.template operator()<P1Triangle>();
    if (nodes == Q1Quadrilateral::nodes) return use.template operator()<Q1Quadrilateral>();
  } else {
    if (nodes == P1Tetrahedron::nodes) return use.template operator()<P1Tetrahedron>();
    if (nodes == Q1Hexahedron::nodes) return use.template operator()<Q1Hexahedron>();
  }
  throw std::logic_error("with_linear_element: no element has this number of nodes");
}

}  // namespace dccast::fem
