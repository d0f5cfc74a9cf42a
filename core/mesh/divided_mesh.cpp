#include "core/mesh/divided_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace dccast::mesh {

namespace {

/// A flat mesh under construction, of which each cell is divided.
class DividedMesh {
public:
  DividedMesh(const Mesh<2>& coarse, int parts) : coarse_(coarse), parts_(parts) {
    fine_.node = coarse.node;
    fine_.nodes_per_element = 4;
  }

  Mesh<2> build() {
    for (int cell = 0; cell < coarse_.elements(); ++cell) divide_cell(coarse_.nodes_of(cell));
    for (const Patch<2>& patch : coarse_.patches) divide_patch(patch);
    return std::move(fine_);
  }

private:
  int add_node(double x, double y) {
    fine_.node.insert(fine_.node.end(), {x, y});
    return fine_.nodes() - 1;
  }

  /// The nodes along a side from a to b, both included. The two cells at a side share them.
  std::vector<int> nodes_between(int a, int b) {
    std::vector<int>& nodes = sides_[{std::min(a, b), std::max(a, b)}];
    if (nodes.empty()) {
      const double *begin = coarse_.point(a), *end = coarse_.point(b);
      nodes.push_back(a);
      for (int k = 1; k < parts_; ++k) {
        const double share = double(k) / parts_;
        nodes.push_back(add_node(begin[0] + share * (end[0] - begin[0]),
                                 begin[1] + share * (end[1] - begin[1])));
      }
      nodes.push_back(b);
    }

    if (nodes.front() == a) return nodes;
    return {nodes.rbegin(), nodes.rend()};
  }

  /// Adds the parts of a cell, row by row from its first side.
  void divide_cell(const int* corner) {
    const auto first = nodes_between(corner[0], corner[1]);
    const auto last = nodes_between(corner[3], corner[2]);
    const auto begin = nodes_between(corner[0], corner[3]);
    const auto end = nodes_between(corner[1], corner[2]);

    std::vector<std::vector<int>> row{first};
    for (int j = 1; j < parts_; ++j) {
      row.push_back({begin[std::size_t(j)]});
      for (int i = 1; i < parts_; ++i)
        row.back().push_back(add_inner_node(corner, double(i) / parts_, double(j) / parts_));
      row.back().push_back(end[std::size_t(j)]);
    }
    row.push_back(last);

    for (std::size_t j = 0; j + 1 < row.size(); ++j)
      for (std::size_t i = 0; i + 1 < row.size(); ++i)
        for (const int node : {row[j][i], row[j][i + 1], row[j + 1][i + 1], row[j + 1][i]})
          fine_.element_node.push_back(node);
  }

  /// By bilinear interpolation between the corners.
  /// @param u, v  [1] place in the cell, along its first side and across
  int add_inner_node(const int* corner, double u, double v) {
    const std::array<double, 4> weight{(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v};
    double x = 0.0, y = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      x += weight[k] * coarse_.point(corner[k])[0];
      y += weight[k] * coarse_.point(corner[k])[1];
    }
    return add_node(x, y);
  }

  void divide_patch(const Patch<2>& whole) {
    Patch<2> patch{whole.name, whole.kind, whole.normal, {}};
    for (const Facet<2>& facet : whole.facets) {
      const auto nodes = nodes_between(facet.node[0], facet.node[1]);
      for (int k = 0; k < parts_; ++k) {
        Facet<2> part;
        part.node = {nodes[std::size_t(k)], nodes[std::size_t(k) + 1]};
        part.element = facet.element * parts_ * parts_ + part_at(first_corner(coarse_, facet), k);
        patch.facets.push_back(part);
      }
    }
    fine_.patches.push_back(std::move(patch));
  }

  /// The number within its cell of the k-th part along a side. Sides turn counterclockwise.
  int part_at(int side, int k) const {
    const int last = parts_ - 1;
    const std::array<std::array<int, 2>, 4> row_and_column{
        {{0, k}, {k, last}, {last, last - k}, {last - k, 0}}};
    const auto [row, column] = row_and_column[std::size_t(side)];
    return row * parts_ + column;
  }

  const Mesh<2>& coarse_;
  int parts_;
  Mesh<2> fine_;
  std::map<std::pair<int, int>, std::vector<int>> sides_;  ///< the nodes along each, by its ends
};

}  // namespace

int first_corner(const Mesh<2>& mesh, const Facet<2>& facet) {
  const int* corner = mesh.nodes_of(facet.element);
  return static_cast<int>(std::find(corner, corner + 4, facet.node[0]) - corner);
}

Mesh<2> divided(const Mesh<2>& coarse, int parts) {
  return DividedMesh(coarse, parts).build();
}

}  // namespace dccast::mesh
