#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// A value and its location.
template <int Dim>
struct Located {
  double value = 0.0;               ///< in the unit of the function that gave it
  std::array<double, Dim> place{};  ///< in the undeformed slab [m]
};

/// Smallest height of an isotherm above the bottom [m], interpolated linearly along the edges of
/// elements, so that it changes smoothly with time; shell.hpp works with whole elements. The
/// location is on the bottom. If no metal is that hot, the height of the slab.
/// @param temperature  (node) [°C]
/// @param isotherm     [°C]
template <int Dim>
Located<Dim> bottom_shell(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                          double isotherm);

extern template Located<2> bottom_shell(const mesh::Mesh<2>&, std::span<const double>, double);
extern template Located<3> bottom_shell(const mesh::Mesh<3>&, std::span<const double>, double);

}  // namespace dccast::casting
