#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/symmetric_tensor.hpp"
#include "core/mesh/row_merging.hpp"

namespace dccast::mechanics {

/// Carries the state of quadrilaterals or hexahedra in rows over to a mesh of which rows were
/// merged in pairs.
///
/// Along each upright line of points the state of two cells is linear in either; the merged cell
/// takes the linear function with their mean and first moment (the projection in the mean square).
/// A stress then does the same work as before on every displacement that the merged cell can have.
template <int Dim>
class RowsOfPoints {
public:
  using Tensor = SymmetricTensor<Dim>;
  static constexpr std::size_t points = 1 << Dim;  ///< of an element

  explicit RowsOfPoints(const mesh::MergedRows& merged)
      : merged_(merged), rows_(merged.made_of()) {}

  /// Whether an element of the mesh after is made of two.
  bool is_pair(std::size_t element) const;
  /// @param field  (element, point), of the mesh before
  std::vector<Tensor> projected(std::span<const Tensor> field) const;
  /// Mean over the volume, at every point of an element. @param field  (element, point), the same
  /// at all points of an element
  std::vector<double> means(std::span<const double> field) const;
  /// Whether all that an element was made of has it. @param flag  (element)
  std::vector<char> all_of(std::span<const char> flag) const;
  /// Nodal vectors that do the same work on the displacements of the merged mesh.
  /// @param force  (node, Dim) of the mesh before, in any unit
  std::vector<double> restricted(std::vector<double> force) const;

private:
  /// Heights of the rows of cells that a row is made of [m]; the second is zero for one.
  std::array<double, 2> heights(std::size_t row) const;
  /// Calls use(element after, first element before, second one) for each element.
  template <class Use>
  void for_each_element(const Use& use) const;

  const mesh::MergedRows& merged_;
  std::vector<std::array<std::size_t, 2>> rows_;  ///< (row after) lowest and highest before
};

extern template class RowsOfPoints<2>;
extern template class RowsOfPoints<3>;

}  // namespace dccast::mechanics
