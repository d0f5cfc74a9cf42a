#pragma once

#include <cstddef>
#include <vector>

#include "core/base/team.hpp"
#include "core/mechanics/point_block.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::mechanics {

/// Divides the elements of a mesh into consecutive parts of whole blocks. No two even parts share a
/// node, nor do two odd ones: all even parts can add to the nodes concurrently, then all odd ones.
/// The division depends on the mesh only, and so does the order of every sum.
class ElementParts {
public:
  /// One part, in the order of the elements.
  explicit ElementParts(std::size_t elements = 0)
      : first_{0, (elements + elements_in_block - 1) / elements_in_block} {}
  /// As many parts as the mesh permits; a single one if it has few elements or they are not
  /// numbered along a direction.
  template <int Dim>
  static ElementParts of(const mesh::Mesh<Dim>& mesh);

  std::size_t parts() const { return first_.size() - 1; }

  /// Calls use(part, first block, end of its blocks) for all parts, divided among the team lent to
  /// the calling thread.
  template <class Use>
  void for_each(const Use& use) const {
    const auto use_part = [&](std::size_t part) { use(part, first_[part], first_[part + 1]); };
    for_each_part((parts() + 1) / 2, [&](std::size_t pair) { use_part(2 * pair); });
    for_each_part(parts() / 2, [&](std::size_t pair) { use_part(2 * pair + 1); });
  }

private:
  template <int Dim>
  bool divide(const mesh::Mesh<Dim>& mesh) const;

  std::vector<std::size_t> first_;  ///< first block of each part, and the end of the last one
};

}  // namespace dccast::mechanics
