#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::casting {

using Edge = std::pair<int, int>;

/// The edges of an element as pairs of its corners: triangle, quadrilateral, tetrahedron or
/// hexahedron.
inline std::span<const Edge> edges_of(int dimension, int nodes_per_element) {
  static constexpr std::array<Edge, 3> triangle{{{0, 1}, {1, 2}, {2, 0}}};
  static constexpr std::array<Edge, 4> quadrilateral{{{0, 1}, {1, 2}, {2, 3}, {3, 0}}};
  static constexpr std::array<Edge, 6> tetrahedron{
      {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
  static constexpr std::array<Edge, 12> hexahedron{{{0, 1},
                                                    {1, 2},
                                                    {2, 3},
                                                    {3, 0},
                                                    {4, 5},
                                                    {5, 6},
                                                    {6, 7},
                                                    {7, 4},
                                                    {0, 4},
                                                    {1, 5},
                                                    {2, 6},
                                                    {3, 7}}};
  if (nodes_per_element == 3) return triangle;
  if (nodes_per_element == 8) return hexahedron;
  if (dimension == 2) return quadrilateral;
  return tetrahedron;
}

/// A figure of a step and where it occurs in the undeformed slab.
struct PlacedFigure {
  double value = 0.0;           ///< [unit of the figure]
  std::vector<double> place{};  ///< coordinates [m]; empty if there is none
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

/// A value and its location.
template <int Dim>
struct Located {
  double value = 0.0;               ///< in the unit of the function that gave it
  std::array<double, Dim> place{};  ///< in the undeformed slab [m]
};

/// Smallest height of an isotherm above the bottom [m], interpolated linearly along the edges of
/// elements, so that it changes smoothly with time; thinnest_shell() works with whole elements. The
/// location is on the bottom. If no metal is that hot, the height of the slab.
/// @param temperature  (node) [°C]
/// @param isotherm     [°C]
template <int Dim>
Located<Dim> bottom_shell(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                          double isotherm);

extern template Located<2> bottom_shell(const mesh::Mesh<2>&, std::span<const double>, double);
extern template Located<3> bottom_shell(const mesh::Mesh<3>&, std::span<const double>, double);

}  // namespace dccast::casting
