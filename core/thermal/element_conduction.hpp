#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "core/fem/element.hpp"
#include "core/fem/jacobian.hpp"

namespace dccast::thermal {

/// The geometry of an element for heat conduction: a volume at each corner, with the gradients of
/// the shape functions there.
template <class Element>
struct ElementConduction {
  /// Coordinates and nodes of an element.
  static constexpr std::size_t dim = Element::dimension, nodes = Element::nodes;
  std::array<double, nodes> volume;  ///< [m^dim], axisymmetric [m3/rad]
  /// (corner, node) [1/m]
  std::array<std::array<std::array<double, dim>, nodes>, nodes> gradient;
};

/// Distance from the axis at the point where the shape functions have these values [m]; 1 in other
/// sections.
template <class Element, class Shape>
double radius_at(const mesh::Mesh<Element::dimension>& mesh, const int* node, const Shape& shape) {
  if constexpr (!fem::is_axisymmetric<Element>) return 1.0;
  double radius = 0.0;
  for (std::size_t i = 0; i < shape.size(); ++i) radius += shape[i] * mesh.point(node[i])[0];
  return radius;
}

/// Integral of each shape function over the element [m^dim], times the radius in an axisymmetric
/// section [m3/rad].
template <class Element>
std::array<double, Element::nodes> corner_volumes(const mesh::Mesh<Element::dimension>& mesh,
                                                  const int* node) {
  /// Derivatives of the coordinates by the reference coordinates [m].
  using Jacobian = fem::Jacobian<Element::dimension>;
  constexpr std::size_t nodes = Element::nodes;
  std::array<double, nodes> volume{};
  if constexpr (nodes == 3) {
    // Exact: integral of N_i N_j is A/12, of N_i^2 A/6.
    const double area = 0.5 * Jacobian(mesh, node, Element::shape_gradient({})).determinant();
    double radii = 0.0;
    for (std::size_t i = 0; i < 3; ++i) radii += mesh.point(node[i])[0];
    for (std::size_t i = 0; i < 3; ++i) {
      volume[i] = fem::is_axisymmetric<Element> ? area / 12.0 * (radii + mesh.point(node[i])[0])
                                                : area / 3.0;
    }
  } else {
    for (std::size_t q = 0; q < std::size_t(Element::points); ++q) {
      const auto& point = Element::point[q];
      const auto shape = Element::shape(point);
      const double weight = Element::weight[q] * radius_at<Element>(mesh, node, shape) *
                            Jacobian(mesh, node, Element::shape_gradient(point)).determinant();
      for (std::size_t i = 0; i < nodes; ++i) volume[i] += weight * shape[i];
    }
  }
  return volume;
}

/// Shifts the gradients at all corners by one vector per node, so that their mean is that of the
/// element: a linear field is then in equilibrium on meshes of such elements of any shape. On a
/// parallelogram or a parallelepiped the shift is zero.
template <class Element>
void shift_to_mean(const mesh::Mesh<Element::dimension>& mesh, const int* node,
                   ElementConduction<Element>& conduction) {
  constexpr std::size_t nodes = Element::nodes, dim = Element::dimension;
  double volume = 0.0;
  for (const double v : conduction.volume) volume += v;

  std::array<std::array<double, dim>, nodes> shift{};
  const auto add = [&](double weight, const auto& gradient) {
    for (std::size_t i = 0; i < nodes; ++i)
      for (std::size_t a = 0; a < dim; ++a) shift[i][a] += weight / volume * gradient[i][a];
  };

  // Add the mean gradient of the element, and subtract that of its corners.
  for (std::size_t q = 0; q < std::size_t(Element::points); ++q) {
    const auto reference = Element::shape_gradient(Element::point[q]);
    const fem::Jacobian<Element::dimension> jacobian(mesh, node, reference);

    std::array<std::array<double, dim>, nodes> gradient;
    for (std::size_t i = 0; i < nodes; ++i)
      gradient[i] = jacobian.gradient(reference[i], 1.0 / jacobian.determinant());
    add(Element::weight[q] * jacobian.determinant() *
            radius_at<Element>(mesh, node, Element::shape(Element::point[q])),
        gradient);
  }

  for (std::size_t c = 0; c < nodes; ++c) add(-conduction.volume[c], conduction.gradient[c]);

  for (auto& corner : conduction.gradient)
    for (std::size_t i = 0; i < nodes; ++i)
      for (std::size_t a = 0; a < dim; ++a) corner[i][a] += shift[i][a];
}

/// Volumes and gradients at the corners of an element.
template <class Element>
ElementConduction<Element> conduction_of(const mesh::Mesh<Element::dimension>& mesh,
                                         const int* node) {
  constexpr std::size_t nodes = Element::nodes;
  constexpr auto corner = fem::reference_corners<Element>();
  constexpr double same_determinant = 1e-9;  // [1] relative: equal up to rounding

  ElementConduction<Element> conduction;
  conduction.volume = corner_volumes<Element>(mesh, node);

  // On a parallelogram or a parallelepiped all corners have the same determinant.
  double first = 0.0;
  bool oblique = false;
  for (std::size_t c = 0; c < nodes; ++c) {
    const auto reference = Element::shape_gradient(corner[c]);
    const fem::Jacobian<Element::dimension> jacobian(mesh, node, reference);
    const double determinant = jacobian.determinant();
    if (c == 0) first = determinant;
    oblique = oblique || std::abs(determinant - first) > same_determinant * first;

    for (std::size_t i = 0; i < nodes; ++i)
      conduction.gradient[c][i] = jacobian.gradient(reference[i], 1.0 / determinant);
  }

  if (oblique) shift_to_mean(mesh, node, conduction);
  return conduction;
}

}  // namespace dccast::thermal
