#pragma once

#include <cstddef>
#include <span>

#include "core/mesh/mesh.hpp"

namespace dccast::mechanics {

/// Mean of a field over the nodes of an element [unit of the field].
/// @param field  (node) [unit of the field]
template <int Dim>
double mean_at_nodes(const mesh::Mesh<Dim>& mesh, int element, std::span<const double> field) {
  const int* node = mesh.nodes_of(element);
  double sum = 0.0;
  for (int i = 0; i < mesh.nodes_per_element; ++i) sum += field[std::size_t(node[i])];
  return sum / mesh.nodes_per_element;
}

/// Mean height of the nodes of an element [m].
template <int Dim>
double centroid_height(const mesh::Mesh<Dim>& mesh, int element) {
  const int* node = mesh.nodes_of(element);
  double sum = 0.0;
  for (int i = 0; i < mesh.nodes_per_element; ++i) sum += mesh.point(node[i])[Dim - 1];
  return sum / mesh.nodes_per_element;
}

}  // namespace dccast::mechanics
