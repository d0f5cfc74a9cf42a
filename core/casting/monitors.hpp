#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// A point inside an element: its shape functions there.
struct Place {
  int element = -1;
  std::array<double, 4> shape{};
};

/// Element and shape functions at a point of the undeformed slab [m]; nothing outside of it.
std::optional<Place> locate(const mesh::Mesh2D& mesh, double x, double y);

/// Displacement interpolated at a place [m]. @param displacement (node, 2)
std::array<double, 2> displacement_at(const mesh::Mesh2D& mesh, const Place& place,
                                      std::span<const double> displacement);

/// Temperature along the side at a distance below the metal level, linear between nodes [°C].
double side_temperature(const mesh::Mesh2D& mesh, std::span<const double> temperature,
                        double height);

/// Depth below the metal level at which the symmetry plane first falls below a temperature; the
/// whole depth where it does not [m].
double sump_depth(const mesh::Mesh2D& mesh, std::span<const double> temperature,
                  double metal_level, double isotherm);

}  // namespace dccast::casting
