#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// The named parts of a slab's boundary.
enum class Patch { symmetry, bottom, side, top };
inline constexpr std::size_t patch_count = 4;

/// A piece of the boundary: an edge in 2D, a triangle or quadrilateral in 3D. In 2D the domain lies
/// to the left of node[0] -> node[1].
template <int Dim>
struct Facet {
  std::array<int, Dim == 2 ? 2 : 4> node{};
  int nodes = Dim == 2 ? 2 : 4;
  int element = -1;
};

/// Nodes, elements of one kind, and the facets of each patch.
///
/// Axes: coordinate 0 points from the symmetry plane to the mould (the paper's x2), the last
/// coordinate upwards (x3), zero at the bottom block.
template <int Dim>
struct Mesh {
  std::vector<double> node;       ///< (node, Dim) [m]
  int nodes_per_element = 0;
  std::vector<int> element_node;  ///< (element, nodes_per_element), positively oriented
  std::array<std::vector<Facet<Dim>>, patch_count> patch;

  int nodes() const { return static_cast<int>(node.size()) / Dim; }
  int elements() const {
    return nodes_per_element == 0 ? 0 : static_cast<int>(element_node.size()) / nodes_per_element;
  }
  const double* point(int n) const { return node.data() + std::size_t(n) * Dim; }
  const int* nodes_of(int e) const {
    return element_node.data() + std::size_t(e) * std::size_t(nodes_per_element);
  }
  const std::vector<Facet<Dim>>& facets(Patch p) const { return patch[std::size_t(p)]; }
  std::vector<Facet<Dim>>& facets(Patch p) { return patch[std::size_t(p)]; }
};

using Mesh2D = Mesh<2>;

/// Nodes of a patch, each once, in the order of its facets.
template <int Dim>
std::vector<int> patch_nodes(const Mesh<Dim>& mesh, Patch patch) {
  std::vector<char> seen(std::size_t(mesh.nodes()), 0);
  std::vector<int> nodes;
  for (const auto& facet : mesh.facets(patch)) {
    for (int i = 0; i < facet.nodes; ++i) {
      const int n = facet.node[std::size_t(i)];
      if (seen[std::size_t(n)] != 0) continue;
      seen[std::size_t(n)] = 1;
      nodes.push_back(n);
    }
  }
  return nodes;
}

/// Unknowns of the patches from which an elimination may sweep through a slab, across it and
/// downwards, each set in rising order; unknown = node * per_node + number.
template <int Dim>
std::array<std::vector<int>, 2> edges_to_sweep_from(const Mesh<Dim>& mesh, int per_node) {
  std::array<std::vector<int>, 2> fronts;
  for (std::size_t f = 0; f < fronts.size(); ++f) {
    for (const int n : patch_nodes(mesh, f == 0 ? Patch::symmetry : Patch::top)) {
      for (int k = 0; k < per_node; ++k) fronts[f].push_back(n * per_node + k);
    }
    std::sort(fronts[f].begin(), fronts[f].end());
  }
  return fronts;
}

}  // namespace dccast::mesh
