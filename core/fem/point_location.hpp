#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "core/mesh/mesh.hpp"

namespace dccast::fem {

/// A point inside an element: its shape functions there.
struct Place {
  int element = -1;
  std::array<double, 8> shape{};  ///< [1] of the element's nodes, as many as it has
};

/// Element and shape functions at a point of a mesh of linear triangles or tetrahedra, or of
/// bilinear quadrilaterals or trilinear hexahedra.
/// @param point  [m] in the undeformed slab
/// @return       the first element that has the point, its boundary included; nothing outside
template <int Dim>
std::optional<Place> locate(const mesh::Mesh<Dim>& mesh,
                            const std::array<double, std::size_t(Dim)>& point);

/// A nodal field interpolated at a place, in the unit of the field.
/// @param values      (node, components)
/// @param components  of a value
/// @param component   which of them
template <int Dim>
double interpolate(const mesh::Mesh<Dim>& mesh, const Place& place, std::span<const double> values,
                   int components = 1, int component = 0) {
  double sum = 0.0;
  const int* node = mesh.nodes_of(place.element);
  for (std::size_t i = 0; i < std::size_t(mesh.nodes_per_element); ++i)
    sum += place.shape[i] * values[std::size_t(node[i] * components + component)];
  return sum;
}

extern template std::optional<Place> locate<2>(const mesh::Mesh<2>&, const std::array<double, 2>&);
extern template std::optional<Place> locate<3>(const mesh::Mesh<3>&, const std::array<double, 3>&);

}  // namespace dccast::fem
