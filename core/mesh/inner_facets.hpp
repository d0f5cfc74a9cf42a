#pragma once

#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::mesh {

/// A facet that two elements share: seen from its own element it faces the other one.
template <int Dim>
struct InnerFacet {
  Facet<Dim> facet;
  int beyond = -1;  ///< the element on its other side, with the greater number
};

/// All facets that two elements share, in the order of the elements they belong to.
template <int Dim>
std::vector<InnerFacet<Dim>> inner_facets(const Mesh<Dim>& mesh);

/// Pieces into which elements are joined in pairs; each element starts alone.
class JoinedPieces {
public:
  explicit JoinedPieces(int elements);
  void join(int a, int b);
  /// The first element of the piece of an element.
  int first_of(int element);

private:
  std::vector<int> parent_;  ///< (element) an earlier one of its piece; itself: the first
};

}  // namespace dccast::mesh
