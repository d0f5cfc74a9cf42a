#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "core/mesh/mesh.hpp"

namespace dccast::fem {

/// A point inside an element, with the values of its shape functions.
struct Place {
  /// Number of the element; -1 if the point lies outside the mesh.
  int element = -1;
  std::array<double, 8> shape{};  ///< (node of the element) [1]
};

/// Locates a point in a mesh of linear triangles or tetrahedra, or of bilinear quadrilaterals or
/// trilinear hexahedra.
/// @param point  [m] in the undeformed slab
/// @return       the first element that contains the point, boundary included; empty outside the
///               mesh
template <int Dim>
std::optional<Place> locate(const mesh::Mesh<Dim>& mesh,
                            const std::array<double, std::size_t(Dim)>& point);

/// Interpolates one component of a nodal field at a place [unit of the field].
/// @param values      (node, components) [unit of the field]
/// @param components  number of components per node
/// @param component   index of the component
template <int Dim>
double interpolate(const mesh::Mesh<Dim>& mesh, const Place& place, std::span<const double> values,
                   int components = 1, int component = 0) {
  double sum = 0.0;
  const int* node = mesh.nodes_of(place.element);
  for (std::size_t i = 0; i < std::size_t(mesh.nodes_per_element); ++i)
    sum += place.shape[i] * values[std::size_t(node[i] * components + component)];
  return sum;
}

}  // namespace dccast::fem
