#include "core/mesh/inner_facets.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/mesh/cell_shape.hpp"

namespace dccast::mesh {

namespace {

/// A facet of an element, with its nodes in ascending order, by which the two of a pair are found.
template <int Dim>
struct Sided {
  decltype(Facet<Dim>::node) key;
  int element, number;  ///< of the facet in its element

  auto operator<=>(const Sided&) const = default;
};

template <int Dim>
Facet<Dim> facet_of(const Mesh<Dim>& mesh, int element, const std::vector<int>& corners) {
  Facet<Dim> facet;
  facet.node.fill(-1);
  facet.nodes = static_cast<int>(corners.size());
  facet.element = element;
  for (std::size_t i = 0; i < corners.size(); ++i)
    facet.node[i] = mesh.nodes_of(element)[corners[i]];
  return facet;
}

}  // namespace

template <int Dim>
std::vector<InnerFacet<Dim>> inner_facets(const Mesh<Dim>& mesh) {
  const auto& shapes = cell_shape(Dim, mesh.nodes_per_element).facets;
  std::vector<Sided<Dim>> sides;
  sides.reserve(std::size_t(mesh.elements()) * shapes.size());
  for (int e = 0; e < mesh.elements(); ++e) {
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      auto key = facet_of(mesh, e, shapes[k]).node;
      std::ranges::sort(key);
      sides.push_back({key, e, static_cast<int>(k)});
    }
  }

  // Sorted by nodes, the two sides of an inner facet follow each other.
  std::ranges::sort(sides);
  std::vector<std::array<int, 3>> pairs;  // element, facet number, element beyond
  for (std::size_t i = 0; i + 1 < sides.size(); ++i)
    if (sides[i].key == sides[i + 1].key)
      pairs.push_back({sides[i].element, sides[i].number, sides[i + 1].element});
  std::ranges::sort(pairs);

  std::vector<InnerFacet<Dim>> inner;
  inner.reserve(pairs.size());
  for (const auto& [element, number, beyond] : pairs)
    inner.push_back({facet_of(mesh, element, shapes[std::size_t(number)]), beyond});
  return inner;
}

JoinedPieces::JoinedPieces(int elements) : parent_(std::size_t(elements), 0) {
  std::iota(parent_.begin(), parent_.end(), 0);
}

int JoinedPieces::first_of(int element) {
  while (parent_[std::size_t(element)] != element) {
    int& above = parent_[std::size_t(element)];
    above = parent_[std::size_t(above)];  // the way gets shorter with each use
    element = above;
  }
  return element;
}

void JoinedPieces::join(int a, int b) {
  a = first_of(a), b = first_of(b);
  parent_[std::size_t(std::max(a, b))] = std::min(a, b);
}

template std::vector<InnerFacet<2>> inner_facets(const Mesh<2>&);
template std::vector<InnerFacet<3>> inner_facets(const Mesh<3>&);

}  // namespace dccast::mesh
