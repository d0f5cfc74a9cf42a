#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// A figure of a step and where it occurs in the undeformed slab.
struct PlacedFigure {
  double value = 0.0;           ///< [unit of the figure]
  std::vector<double> place{};  ///< coordinates [m]; empty if there is none
};

/// A value and its location, during the search for a figure.
template <int Dim>
struct Located {
  double value = 0.0;               ///< [unit of the function that returns it]
  std::array<double, Dim> place{};  ///< in the undeformed slab [m]

  operator PlacedFigure() const { return {value, {place.begin(), place.end()}}; }
};

/// Smallest thickness of the shell between the bottom block and the melt: the length [m] of the
/// shortest path through it, and where that path begins at the bottom.
///
/// A path runs from node to node, from the bottom to the melt that is connected to the top (or to
/// the top itself). Its part in solid elements counts with its length, its part in liquid ones with
/// zero. In a 2D section it is the shortest cut that separates the symmetry plane from the faces:
/// the thickness is zero exactly if no path over edges of solid elements connects the two; solid
/// cells that touch only at a corner do not hold together. In 3D a hole does not separate the slab:
/// zero means that melt connected to the top stands on the block there.
///
/// @param solid  (element) carries stress
/// @return       empty if the mesh has no named bottom
template <int Dim>
std::optional<PlacedFigure> thinnest_shell(const mesh::Mesh<Dim>& mesh,
                                           std::span<const char> solid);

/// Whether melt touches the bottom somewhere; if not, there is a shell of some thickness. Costs a
/// hundredth of thinnest_shell().
template <int Dim>
bool melt_touches_bottom(const mesh::Mesh<Dim>& mesh, std::span<const char> solid);

/// Smallest height of an isotherm above the block [m], interpolated linearly along the edges of
/// elements, so that it changes smoothly with time; thinnest_shell() works with whole elements. The
/// location is on the bottom. If no metal is that hot, the height of the slab.
/// @param temperature  (node) [°C]
/// @param isotherm     [°C]
template <int Dim>
Located<Dim> bottom_shell(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                          double isotherm);

/// A horizontal cut through the slab.
template <int Dim>
struct Slice {
  Located<Dim> surface;  ///< [°C] hottest point of the side
  Located<Dim> shell;    ///< [m] smallest distance from the side to the isotherm, at the isotherm
};

/// Cuts the mesh at a height. Temperatures are linear along the edges of elements and between the
/// points where the edges meet the cut.
///
/// If the side itself is hotter than the isotherm, the shell is zero. If no metal at this height is
/// that hot, the shell is as thick as the slab, measured from the side.
/// @param temperature  (node) [°C]
/// @param height       [m] above the bottom of the undeformed slab
/// @param isotherm     [°C]
/// @return             empty if the slab has no side at that height
template <int Dim>
std::optional<Slice<Dim>> slice_at(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                                   double height, double isotherm);

/// Mean height of the side that is not frozen [m]: its area hotter than an isotherm, divided by its
/// length around the slab; the place is the highest frozen point of the side. Temperatures are
/// linear on edges in 2D and on triangles in 3D.
/// @param temperature  (node) [°C]
/// @param isotherm     [°C]
/// @return             zero if the mesh has no named side
template <int Dim>
Located<Dim> unfrozen_side(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                           double isotherm);

/// The hottest point of the side at a height and its temperature [°C]: the same as slice_at()
/// finds, without visiting every element.
/// @param temperature  (node) [°C]
/// @param height       [m] above the bottom of the undeformed slab
/// @return             empty if the slab has no side at that height
template <int Dim>
std::optional<Located<Dim>> hottest_side_at(const mesh::Mesh<Dim>& mesh,
                                            std::span<const double> temperature, double height);

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

}  // namespace dccast::casting
