#pragma once

#include <span>

#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// Largest temperature of the sides at a height above the bottom block, linear between nodes [°C].
/// Above and below the sides it is that of their ends; 0 for a mesh whose sides are not named.
/// @param temperature  (node) [°C]
template <int Dim>
double side_temperature(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                        double height);

/// Depth below the metal level at which the middle of the slab, where most symmetry planes meet,
/// first falls below a temperature; the whole depth where it does not [m].
/// @param temperature  (node) [°C]
template <int Dim>
double sump_depth(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                  double metal_level, double isotherm);

extern template double side_temperature(const mesh::Mesh<2>&, std::span<const double>, double);
extern template double side_temperature(const mesh::Mesh<3>&, std::span<const double>, double);
extern template double sump_depth(const mesh::Mesh<2>&, std::span<const double>, double, double);
extern template double sump_depth(const mesh::Mesh<3>&, std::span<const double>, double, double);

}  // namespace dccast::casting
