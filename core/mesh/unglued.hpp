#pragma once

#include <optional>
#include <span>
#include <utility>

#include "core/mesh/mesh.hpp"

/// Gaps in a mesh that look closed: neither heat nor force passes between cells that touch but do
/// not share their nodes.
namespace dccast::mesh {

/// Nodes on outer facets that do not have them: doubled nodes, or a node that hangs in the side of
/// a cell.
struct Unglued {
  int node = -1;          ///< the first of them
  int same_place = -1;    ///< another node at its place; -1: it hangs in a side
  std::size_t nodes = 0;  ///< number of them
};

/// Finds nodes that lie on outer facets of other cells, within 1e-6 of the shortest edge of the
/// facet. @param outer  all facets that one element has. @return  empty if there are none
template <int Dim>
std::optional<Unglued> find_unglued(const Mesh<Dim>& mesh, std::span<const Facet<Dim>> outer);

/// Parts of a mesh between which no element shares a facet with another.
struct Pieces {
  std::size_t number = 1;
  int second = -1;  ///< an element that is not in the piece of element 0; -1: there is none
};

/// @param elements    number of elements
/// @param neighbours  elements that share a facet
Pieces find_pieces(int elements, std::span<const std::pair<int, int>> neighbours);

}  // namespace dccast::mesh
