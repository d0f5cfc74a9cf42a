#pragma once

#include <cstddef>
#include <span>

#include "core/mechanics/mechanics_forms.hpp"
#include "core/mechanics/slab_state.hpp"
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

/// Deviation of the liquid's pressure from the metallostatic one along the solidification front.
struct FrontPressure {
  double error = 0.0;  ///< [1] root mean square, relative; zero if there is no liquid
  int worst = -1;      ///< element with the largest contribution; -1 if there is none
};

/// A liquid at rest.
struct RestingLiquid {
  double specific_weight;  ///< [N/m3]
  double level;            ///< [m] height of its surface
};

template <int Dim>
FrontPressure front_pressure(const MechanicsForms<Dim>& forms, const mesh::Mesh<Dim>& mesh,
                             const SlabState<Dim>& state, const RestingLiquid& liquid);

extern template FrontPressure front_pressure(const MechanicsForms<2>&, const mesh::Mesh<2>&,
                                             const SlabState<2>&, const RestingLiquid&);
extern template FrontPressure front_pressure(const MechanicsForms<3>&, const mesh::Mesh<3>&,
                                             const SlabState<3>&, const RestingLiquid&);

}  // namespace dccast::mechanics
