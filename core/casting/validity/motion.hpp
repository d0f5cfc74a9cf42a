#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/casting/validity/extreme.hpp"
#include "core/material/mechanical_properties.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/row_merging.hpp"

namespace dccast::casting {

/// Mean of the corners of an element, Dim coordinates [m].
template <int Dim>
std::vector<double> centroid(const mesh::Mesh<Dim>& mesh, int element);

/// How an element has turned: of the rotation in the polar decomposition of I + grad u. In 2D the
/// angle [rad], anticlockwise, -pi to pi; in 3D the unit quaternion, its real part first [1].
template <int Dim>
using Turn = std::array<double, Dim == 2 ? 1 : 4>;

/// The turn of no motion.
template <int Dim>
constexpr Turn<Dim> no_turn() {
  if constexpr (Dim == 2)
    return {0.0};
  else
    return {1.0, 0.0, 0.0, 0.0};
}

/// The turn of an element; grad u is its mean over the element in 2D, that of the middle in 3D.
/// @param displacement  (node, Dim) [m]
template <int Dim>
Turn<Dim> turn_of(const mesh::Mesh<Dim>& mesh, int element, std::span<const double> displacement);
template <>
Turn<2> turn_of<2>(const mesh::Mesh2D& mesh, int element, std::span<const double> displacement);
template <>
Turn<3> turn_of<3>(const mesh::Mesh3D& mesh, int element, std::span<const double> displacement);

/// The angle of the rotation that leads from one turn to another [rad], 0 to pi.
template <int Dim>
double angle_between(const Turn<Dim>& from, const Turn<Dim>& to);
template <>
double angle_between<2>(const Turn<2>& from, const Turn<2>& to);
template <>
double angle_between<3>(const Turn<3>& from, const Turn<3>& to);

/// The largest angle by which a solid element has turned since it solidified [rad].
///
/// What a cell of melt went through before does not count: between a mould that holds and a shell
/// that leaves it the melt shears at will, and the strain of solid counts from solidification.
///
/// @param solid        (element) carries stress
/// @param growing      first element of the row that still stretches: its motion is the mesh's
/// @param when_liquid  (element, numbers of a turn) when it was last liquid or growing; brought up
///                     to date
template <int Dim>
Extreme largest_rotation(const mesh::Mesh<Dim>& mesh, std::span<const char> solid,
                         std::span<const double> displacement, int growing,
                         std::vector<double>& when_liquid);

/// Carries the turns of elements over a merging of rows: that of a pair is that of its lower cell.
/// @param when_liquid  (element, numbers of a turn) as largest_rotation() keeps it, or empty
template <int Dim>
void merge_turns(const mesh::MergedRows& merged, std::vector<double>& when_liquid);

/// How far the butt has slid over the bottom block [m]: of the bottom nodes of solid elements, the
/// largest distance of the sideways displacement from what thermal contraction alone permits, from
/// nothing to the whole of it, counted from the symmetry plane. In 3D, where no one path leads from
/// a plane to a node, the whole of it is the distance from the plane times the strain of the
/// coldest bottom facet.
///
/// @param solid_below  temperature from which the contraction counts [°C]
/// @param temperature  (node) [°C]
template <int Dim>
Extreme largest_slip(const mesh::Mesh<Dim>& mesh, std::span<const char> solid,
                     std::span<const double> displacement, std::span<const double> temperature,
                     const material::MechanicalProperties& properties, double solid_below);
template <>
Extreme largest_slip<2>(const mesh::Mesh2D&, std::span<const char>, std::span<const double>,
                        std::span<const double>, const material::MechanicalProperties&, double);
template <>
Extreme largest_slip<3>(const mesh::Mesh3D&, std::span<const char>, std::span<const double>,
                        std::span<const double>, const material::MechanicalProperties&, double);

}  // namespace dccast::casting
