#pragma once

#include <optional>
#include <span>

#include "core/material/mechanical_properties.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// Stresses that are left in a cold slab.
struct ResidualStress {
  /// [m] below the face, at half the height, where the axial stress first changes its sign; absent:
  /// it does not
  std::optional<double> axial_depth;
  std::optional<double> hoop_depth;  ///< [m] the same of the stress along the face
  double tension = 0.0;              ///< [Pa] greatest principal stress of an element
  double elastic_energy = 0.0;       ///< [J/m3] mean over the metal
};

/// A stress at a place on the way from the face inwards.
struct StressAtDepth {
  double depth = 0.0;   ///< [m] below the face
  double stress = 0.0;  ///< [Pa]
};

/// Depth at which a stress first changes its sign [m], linear between two places.
/// @param path  from the face inwards
std::optional<double> find_sign_change(std::span<const StressAtDepth> path);

/// Measures the stresses of a slab. The path runs at half the height from the side to the symmetry
/// plane or axis, in a solid from the middle of the wide face along y. Stresses are means of
/// elements, in their own axes where a slab turns.
/// @param temperature  (node) [°C] @param round  the section is axisymmetric
template <int Dim>
ResidualStress residual_stress(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                               const mechanics::SlabState<Dim>& slab,
                               const material::MechanicalProperties& properties, bool round);

}  // namespace dccast::casting
