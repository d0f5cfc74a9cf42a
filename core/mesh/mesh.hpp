#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// Role of a part of the boundary.
enum class PatchKind { symmetry, bottom, side, top };
/// Number of kinds, and their names in meshes and results.
inline constexpr std::size_t patch_kinds = 4;
inline constexpr std::array<const char*, patch_kinds> patch_kind_name{"symmetry", "bottom", "side",
                                                                      "top"};
/// The name of a kind, e.g. "symmetry".
inline const char* name_of(PatchKind kind) {
  return patch_kind_name[std::size_t(kind)];
}

/// A piece of the boundary: an edge in 2D, a triangle or quadrilateral in 3D. In 2D the domain lies
/// to the left of node[0] -> node[1]; in 3D the nodes turn counterclockwise seen from outside.
template <int Dim>
struct Facet {
  /// Nodes of the facet; the last of four is not used by a triangle.
  std::array<int, Dim == 2 ? 2 : 4> node{};
  int nodes = Dim == 2 ? 2 : 4;
  int element = -1;  ///< to which it belongs
};

/// A named part of the boundary. There may be several of a kind: two symmetry planes, four faces.
template <int Dim>
struct Patch {
  std::string name;  ///< name of the kind if it is the only patch of it
  PatchKind kind = PatchKind::side;
  std::array<double, Dim> normal{};  ///< outward unit normal of the undeformed slab [1]
  std::vector<Facet<Dim>> facets;
};

/// Outward normal of a patch in a section whose coordinate 0 points to the mould and whose last
/// coordinate points upwards [1].
template <int Dim>
std::array<double, Dim> usual_normal(PatchKind kind) {
  std::array<double, Dim> normal{};
  const bool across = kind == PatchKind::symmetry || kind == PatchKind::side;
  const bool outward = kind == PatchKind::side || kind == PatchKind::top;
  normal[across ? 0 : Dim - 1] = outward ? 1.0 : -1.0;
  return normal;
}

/// Nodes, elements of one kind, and the patches of the boundary.
///
/// Axes: in 2D coordinate 0 points from the symmetry plane to the mould (the paper's x2); in 3D
/// coordinates 0 and 1 point from the planes x = 0 and y = 0 to the narrow and the wide face. The
/// last coordinate (x3) points upwards and is zero at the bottom block, or at the lip of its bowl.
template <int Dim>
struct Mesh {
  std::vector<double> node;  ///< (node, Dim) [m]
  int nodes_per_element = 0;
  std::vector<int> element_node;  ///< (element, nodes_per_element), positively oriented
  std::vector<Patch<Dim>> patches;

  /// Numbers of nodes and elements.
  int nodes() const { return static_cast<int>(node.size()) / Dim; }
  int elements() const {
    return nodes_per_element == 0 ? 0 : static_cast<int>(element_node.size()) / nodes_per_element;
  }
  const double* point(int n) const { return node.data() + std::size_t(n) * Dim; }  ///< [m]
  /// Largest value of a coordinate over the nodes [m], at least 0.
  double largest(int coordinate) const {
    double value = 0.0;
    for (int n = 0; n < nodes(); ++n) value = std::max(value, point(n)[coordinate]);
    return value;
  }
  /// The node numbers of an element.
  const int* nodes_of(int e) const {
    return element_node.data() + std::size_t(e) * std::size_t(nodes_per_element);
  }

  /// The patch with a name; null if there is none.
  const Patch<Dim>* find(const std::string& name) const {
    const auto found = std::ranges::find(patches, name, &Patch<Dim>::name);
    return found == patches.end() ? nullptr : &*found;
  }
  /// The facets of the only patch of a kind, which is created if there is none yet.
  /// @throws std::logic_error  there are several
  std::vector<Facet<Dim>>& facets(PatchKind kind) {
    if (Patch<Dim>* patch = only(*this, kind)) return patch->facets;
    patches.push_back({name_of(kind), kind, usual_normal<Dim>(kind), {}});
    return patches.back().facets;
  }
  /// The facets of the only patch of a kind; empty if there is none.
  /// @throws std::logic_error  there are several
  const std::vector<Facet<Dim>>& facets(PatchKind kind) const {
    static const std::vector<Facet<Dim>> none;
    const Patch<Dim>* patch = only(*this, kind);
    return patch == nullptr ? none : patch->facets;
  }

private:
  // One function for constant and changeable meshes; null if there is no patch of the kind.
  template <class Self>
  static auto only(Self& self, PatchKind kind) -> decltype(self.patches.data()) {
    decltype(self.patches.data()) found = nullptr;
    for (auto& patch : self.patches) {
      if (patch.kind != kind) continue;
      if (found != nullptr) throw std::logic_error("Mesh: several patches of one kind");
      found = &patch;
    }
    return found;
  }
};

using Mesh2D = Mesh<2>;
using Mesh3D = Mesh<3>;

/// Calls `use(facet, patch)` for every facet of every patch of a kind, in the order of the patches.
template <int Dim, class Use>
void for_each_facet(const Mesh<Dim>& mesh, PatchKind kind, Use&& use) {
  for (const Patch<Dim>& patch : mesh.patches) {
    if (patch.kind != kind) continue;
    for (const Facet<Dim>& facet : patch.facets) use(facet, patch);
  }
}

/// Nodes of all patches of a kind, each once, in the order of their facets.
template <int Dim>
std::vector<int> patch_nodes(const Mesh<Dim>& mesh, PatchKind kind) {
  std::vector<char> seen(std::size_t(mesh.nodes()), 0);
  std::vector<int> nodes;
  for_each_facet(mesh, kind, [&](const Facet<Dim>& facet, const Patch<Dim>&) {
    for (int i = 0; i < facet.nodes; ++i) {
      const int n = facet.node[std::size_t(i)];
      if (std::exchange(seen[std::size_t(n)], char{1}) == 0) nodes.push_back(n);
    }
  });
  return nodes;
}

/// Nodes of one patch, each once, in the order of its facets.
template <int Dim>
std::vector<int> patch_nodes(const Patch<Dim>& patch) {
  std::vector<int> nodes;
  std::vector<char> seen;
  for (const Facet<Dim>& facet : patch.facets) {
    for (int i = 0; i < facet.nodes; ++i) {
      const std::size_t n = std::size_t(facet.node[std::size_t(i)]);
      if (n >= seen.size()) seen.resize(n + 1, 0);
      if (std::exchange(seen[n], char{1}) == 0) nodes.push_back(static_cast<int>(n));
    }
  }
  return nodes;
}

/// Sets of unknowns at patches from which an elimination may sweep through a slab, horizontally and
/// downwards, each in ascending order; unknown = node * per_node + number.
template <int Dim>
std::array<std::vector<int>, 2> edges_to_sweep_from(const Mesh<Dim>& mesh, int per_node) {
  std::array<std::vector<int>, 2> fronts;
  for (std::size_t f = 0; f < fronts.size(); ++f) {
    for (const int n : patch_nodes(mesh, f == 0 ? PatchKind::symmetry : PatchKind::top)) {
      for (int k = 0; k < per_node; ++k) fronts[f].push_back(n * per_node + k);
    }
    std::sort(fronts[f].begin(), fronts[f].end());
  }
  return fronts;
}

/// Mean of a field over the nodes of an element [unit of the field].
/// @param field  (node) [unit of the field]
template <int Dim>
double mean_at_nodes(const Mesh<Dim>& mesh, int element, std::span<const double> field) {
  const int* node = mesh.nodes_of(element);
  double sum = 0.0;
  for (int i = 0; i < mesh.nodes_per_element; ++i) sum += field[std::size_t(node[i])];
  return sum / mesh.nodes_per_element;
}

}  // namespace dccast::mesh
