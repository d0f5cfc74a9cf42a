#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/tensors.hpp"
#include "core/mesh/row_merging.hpp"

namespace dccast::mechanics {

/// Transfers the state of rows of quadrilaterals or hexahedra to a mesh in which pairs of rows were
/// merged.
///
/// Along each vertical line of points the state is linear in each of the two cells; the merged cell
/// gets the linear function with the same mean and first moment (the L2 projection). A stress then
/// does the same work as before on every displacement that the merged cell can have.
///
/// Units: fields in any unit; results in the unit of the field.
template <int Dim>
class RowsOfPoints {
public:
  using Tensor = SymmetricTensor<Dim>;
  static constexpr std::size_t points = 1 << Dim;  ///< integration points per element

  explicit RowsOfPoints(const mesh::MergedRows& merged)
      : merged_(merged), rows_(merged.made_of()) {}

  /// Whether an element of the merged mesh is made of two.
  bool is_pair(std::size_t element) const;
  /// @param field  (element, point) on the mesh before merging
  std::vector<Tensor> projected(std::span<const Tensor> field) const;
  /// Volume mean, repeated for every point of an element.
  /// @param field  (element, point), uniform within an element
  std::vector<double> means(std::span<const double> field) const;
  /// Mean along each vertical line of points, for a field that must not become negative.
  /// @param field  (element, point)
  std::vector<double> point_means(std::span<const double> field) const;
  /// Whether all the elements that were merged into an element have a flag. @param flag  (element)
  std::vector<char> all_of(std::span<const char> flag) const;
  /// Nodal forces that do the same work on the displacements of the merged mesh.
  /// @param force  (node, Dim) on the mesh before merging
  std::vector<double> restricted(std::vector<double> force) const;

private:
  /// Heights of the rows of cells that a row is made of [m]; the second is zero if it is made of
  /// one.
  std::array<double, 2> heights(std::size_t row) const;
  /// Calls use(element after, first element before, second one) for each element.
  template <class Use>
  void for_each_element(const Use& use) const;

  const mesh::MergedRows& merged_;
  /// (row after merging) lowest and highest row before
  std::vector<std::array<std::size_t, 2>> rows_;
};

}  // namespace dccast::mechanics
