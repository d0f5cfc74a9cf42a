#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/casting/validity/extreme.hpp"
#include "core/material/mechanical_properties.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// Mean of the corners of an element [m].
std::array<double, 2> centroid(const mesh::Mesh2D& mesh, int element);

/// Angle by which an element has turned [rad], anticlockwise, -pi to pi: of the rotation in the
/// polar decomposition of I + mean of grad u over the element.
/// @param displacement  (node, 2) [m]
double rotation(const mesh::Mesh2D& mesh, int element, std::span<const double> displacement);

/// The largest angle by which a solid element has turned since it solidified [rad].
///
/// What a cell of melt went through before does not count: between a mould that holds and a shell
/// that leaves it the melt shears at will, and the strain of solid counts from solidification.
///
/// @param solid        (element) carries stress
/// @param growing      first element of the row that still stretches: its motion is the mesh's
/// @param when_liquid  (element) angle when it was last liquid or growing; brought up to date
Extreme largest_rotation(const mesh::Mesh2D& mesh, std::span<const char> solid,
                         std::span<const double> displacement, int growing,
                         std::vector<double>& when_liquid);

/// How far the butt has slid over the bottom block [m]: of the bottom nodes of solid elements, the
/// largest distance of the sideways displacement from what thermal contraction alone permits, from
/// nothing to the whole of it, counted from the symmetry plane.
///
/// @param solid_below  temperature from which the contraction counts [°C]
/// @param temperature  (node) [°C]
Extreme largest_slip(const mesh::Mesh2D& mesh, std::span<const char> solid,
                     std::span<const double> displacement, std::span<const double> temperature,
                     const material::MechanicalProperties& properties, double solid_below);

}  // namespace dccast::casting
