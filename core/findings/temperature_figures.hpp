#pragma once

#include <span>

#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// Largest temperature of the sides at a height above the bottom block, linear between nodes [°C].
/// Above and below the sides the value at their end is used; 0 if the mesh has no named sides.
/// @param temperature  (node) [°C]
/// @param height       [m]
template <int Dim>
double side_temperature(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                        double height);

/// Depth of the sump [m]: distance below the metal level at which the centre of the slab, where
/// most symmetry planes meet, first falls below the isotherm; the whole depth if it never does.
/// @param temperature  (node) [°C]
/// @param metal_level  [m]
/// @param isotherm     [°C]
template <int Dim>
double sump_depth(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                  double metal_level, double isotherm);

extern template double side_temperature(const mesh::Mesh<2>&, std::span<const double>, double);
extern template double side_temperature(const mesh::Mesh<3>&, std::span<const double>, double);
extern template double sump_depth(const mesh::Mesh<2>&, std::span<const double>, double, double);
extern template double sump_depth(const mesh::Mesh<3>&, std::span<const double>, double, double);

}  // namespace dccast::casting
