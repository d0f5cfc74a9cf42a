#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// A value and where it is.
template <int Dim>
struct Located {
  double value = 0.0;               ///< in the unit of the function that gave it
  std::array<double, Dim> place{};  ///< in the undeformed slab [m]
};

/// Least height of metal at an isotherm above the bottom [m], linear along the edges of elements,
/// so that it changes smoothly with time; casting/validity finds the cut of the shell by elements.
/// Its place is on the bottom. Without metal as hot as that it is the height of the slab.
/// @param temperature  (node) [°C]
/// @param isotherm     [°C]
template <int Dim>
Located<Dim> bottom_shell(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                          double isotherm);

extern template Located<2> bottom_shell(const mesh::Mesh<2>&, std::span<const double>, double);
extern template Located<3> bottom_shell(const mesh::Mesh<3>&, std::span<const double>, double);

}  // namespace dccast::casting
