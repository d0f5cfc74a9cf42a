#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/casting/findings/shell.hpp"
#include "core/material/mechanical_properties.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/row_merging.hpp"

namespace dccast::casting {

/// Mean of the corners of an element, Dim coordinates [m].
template <int Dim>
std::vector<double> centroid(const mesh::Mesh<Dim>& mesh, int element);

/// Rotation of an element, from the polar decomposition of I + grad u: in 2D the angle [rad],
/// anticlockwise, -pi to pi; in 3D the unit quaternion, real part first [1].
template <int Dim>
using Turn = std::array<double, Dim == 2 ? 1 : 4>;

/// The turn of an element, from the mean of grad u over the element in 2D and from grad u at its
/// centre in 3D.
/// @param displacement  (node, Dim) [m]
Turn<2> element_turn(const mesh::Mesh2D& mesh, int element, std::span<const double> displacement);
/// The same in 3D, with the gradient at the centre of the cell.
Turn<3> element_turn(const mesh::Mesh3D& mesh, int element, std::span<const double> displacement);

/// The largest angle by which a solid element has turned since it solidified [rad], and its place.
///
/// Rotation before solidification does not count: melt between a holding mould and a receding shell
/// shears freely, and the strain of the solid is counted from solidification.
///
/// @param solid        (element) carries stress, and its grains have grown together
/// @param displacement (node, Dim) [m]
/// @param growing      first element of the row that still stretches, whose motion is that of the
///                     mesh
/// @param when_liquid  (element, components of a turn) [rad] or [1], turn when the element was last
///                     liquid or growing; updated
template <int Dim>
PlacedFigure largest_rotation(const mesh::Mesh<Dim>& mesh, std::span<const char> solid,
                              std::span<const double> displacement, int growing,
                              std::vector<double>& when_liquid);

/// Transfers the turns of elements to the merged mesh: a merged cell takes that of its lower cell.
/// @param when_liquid  (element, components of a turn) [rad] or [1], see largest_rotation(); may be
///                     empty
template <int Dim>
void merge_turns(const mesh::MergedRows& merged, std::vector<double>& when_liquid);

/// Sliding of the butt over the bottom block [m]: over the bottom nodes of solid elements, the
/// largest distance of the lateral displacement from the range that thermal contraction explains.
/// This range reaches from zero to the full free contraction, counted from the symmetry plane. In
/// 3D, where the path from a plane to a node is not unique, the full contraction is the distance
/// from the plane times the thermal strain of the coldest bottom facet.
///
/// @param solid_below  temperature below which the contraction is counted [°C]
/// @param temperature  (node) [°C]
PlacedFigure largest_slip(const mesh::Mesh2D& mesh, std::span<const char> solid,
                          std::span<const double> displacement, std::span<const double> temperature,
                          const material::MechanicalProperties& properties, double solid_below);
/// The same in 3D: the larger of the slips along x and along y.
PlacedFigure largest_slip(const mesh::Mesh3D& mesh, std::span<const char> solid,
                          std::span<const double> displacement, std::span<const double> temperature,
                          const material::MechanicalProperties& properties, double solid_below);

}  // namespace dccast::casting
