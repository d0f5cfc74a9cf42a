#include "core/mesh/cell_shape.hpp"

#include <algorithm>
#include <stdexcept>

namespace dccast::mesh {

const std::vector<CellShape>& cell_shapes() {
  static const std::vector<CellShape> shapes{
      {.dimension = 1, .nodes = 2, .gmsh = 1, .plural = "lines", .edges = {{0, 1}}, .facets = {}},
      {.dimension = 2,
       .nodes = 3,
       .gmsh = 2,
       .plural = "triangles",
       .edges = {{0, 1}, {1, 2}, {2, 0}},
       .facets = {{0, 1}, {1, 2}, {2, 0}}},
      {.dimension = 2,
       .nodes = 4,
       .gmsh = 3,
       .plural = "quadrilaterals",
       .edges = {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
       .facets = {{0, 1}, {1, 2}, {2, 3}, {3, 0}}},
      {.dimension = 3,
       .nodes = 4,
       .gmsh = 4,
       .plural = "tetrahedra",
       .edges = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}},
       .facets = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}},
      {.dimension = 3,
       .nodes = 8,
       .gmsh = 5,
       .plural = "hexahedra",
       .edges = {{0, 1},
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
                 {3, 7}},
       .facets =
           {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}},
  };
  return shapes;
}

const CellShape& cell_shape(int dimension, int nodes) {
  for (const CellShape& shape : cell_shapes())
    if (shape.dimension == dimension && shape.nodes == nodes) return shape;
  throw std::logic_error("cell_shape: no cell has this number of nodes");
}

const CellShape& cell_shape(int dimension, ElementKind element) {
  const int simplex = dimension + 1, brick = 1 << dimension;
  return cell_shape(dimension, element == ElementKind::p1 ? simplex : brick);
}

const CellShape* find_gmsh_shape(int number) {
  const auto& shapes = cell_shapes();
  const auto found = std::ranges::find(shapes, number, &CellShape::gmsh);
  return found == shapes.end() ? nullptr : &*found;
}

}  // namespace dccast::mesh
