#pragma once

#include <array>
#include <span>
#include <utility>

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

}  // namespace dccast::casting
