#include "core/mesh/cell_division.hpp"

namespace dccast::mesh {

// Corners in 2D: 0 and 1 below, 2 above 0, 3 above 1. In 3D: 0 to 3 below, 4 to 7 above them.

template <>
const CellDivision<2>& division_of<2>(ElementKind kind) {
  static const CellDivision<2> whole{
      {{0, 1, 3, 2}}, {{{0, 1}, 0}}, {{{3, 2}, 0}}, {{{{2, 0}, 0}}, {{{1, 3}, 0}}}};
  static const CellDivision<2> triangles{
      {{0, 1, 3}, {0, 3, 2}}, {{{0, 1}, 0}}, {{{3, 2}, 1}}, {{{{2, 0}, 1}}, {{{1, 3}, 0}}}};
  return kind == ElementKind::p1 ? triangles : whole;
}

template <>
const CellDivision<3>& division_of<3>(ElementKind kind) {
  static const CellDivision<3> whole{
      {{0, 1, 2, 3, 4, 5, 6, 7}},
      {{{0, 3, 2, 1}, 0}},
      {{{4, 5, 6, 7}, 0}},
      {{{{0, 1, 5, 4}, 0}}, {{{1, 2, 6, 5}, 0}}, {{{2, 3, 7, 6}, 0}}, {{{3, 0, 4, 7}, 0}}}};
  // Six around the diagonal from 0 to 6. Every face is cut from its corner nearest to 0 to the one
  // opposite, so that cells whose base starts at the same corner fit together.
  static const CellDivision<3> tetrahedra{
      {{0, 1, 2, 6}, {0, 5, 1, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 4, 5, 6}, {0, 7, 4, 6}},
      {{{0, 3, 2}, 2}, {{0, 2, 1}, 0}},
      {{{4, 5, 6}, 4}, {{4, 6, 7}, 5}},
      {{{{0, 1, 5}, 1}, {{0, 5, 4}, 4}},
       {{{1, 2, 6}, 0}, {{1, 6, 5}, 1}},
       {{{2, 3, 6}, 2}, {{3, 7, 6}, 3}},
       {{{3, 0, 7}, 3}, {{0, 4, 7}, 5}}}};
  return kind == ElementKind::p1 ? tetrahedra : whole;
}

}  // namespace dccast::mesh
