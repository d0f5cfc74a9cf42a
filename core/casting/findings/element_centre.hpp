#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "core/fem/element.hpp"
#include "core/fem/jacobian.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// An element at its centre.
template <int Dim>
struct ElementCentre {
  double temperature = 0.0;         ///< [°C] mean of the nodes
  double gradient = 0.0;            ///< [K/m] of the temperature
  double volume = 0.0;              ///< [m^Dim], of a billet [m3/rad]
  std::array<double, Dim> place{};  ///< [m]
};

/// @tparam Element  that of the mesh
template <class Element, int Dim>
ElementCentre<Dim> centre_of_element(const mesh::Mesh<Dim>& mesh, int e,
                                     std::span<const double> temperature, bool round) {
  // One point integrates simplices and parallelepipeds exactly.
  static const auto reference = Element::shape_gradient(
      Element::nodes == Dim + 1 ? Element::point[0] : std::array<double, Dim>{});
  static const double measure = [] {
    double sum = 0.0;
    for (const double w : Element::weight) sum += w;
    return sum;
  }();

  const int* node = mesh.nodes_of(e);
  const fem::Jacobian<Dim> jacobian(mesh, node, reference);
  const double determinant = jacobian.determinant();

  ElementCentre<Dim> centre;
  std::array<double, Dim> along{};
  constexpr double share = 1.0 / Element::nodes;
  for (std::size_t i = 0; i < Element::nodes; ++i) {
    const double t = temperature[std::size_t(node[i])];
    centre.temperature += share * t;
    for (std::size_t d = 0; d < Dim; ++d) {
      along[d] += t * reference[i][d];
      centre.place[d] += share * mesh.point(node[i])[d];
    }
  }

  double squared = 0.0;
  for (const double g : jacobian.gradient(along, 1.0 / determinant)) squared += g * g;
  centre.gradient = std::sqrt(squared);
  centre.volume = measure * determinant * (round ? centre.place[0] : 1.0);
  return centre;
}

/// An element at its centre.
/// @param temperature  (node) [°C]
/// @param round        the section is axisymmetric
template <int Dim>
ElementCentre<Dim> centre_of(const mesh::Mesh<Dim>& mesh, int e,
                             std::span<const double> temperature, bool round) {
  return fem::with_linear_element<Dim>(mesh.nodes_per_element, [&]<class Element>() {
    return centre_of_element<Element>(mesh, e, temperature, round);
  });
}

}  // namespace dccast::casting
