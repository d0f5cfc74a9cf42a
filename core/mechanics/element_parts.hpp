#pragma once

#include <cstddef>
#include <vector>

#include "core/base/team.hpp"
#include "core/mechanics/point_block.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::mechanics {

/// The elements of a mesh in consecutive parts of whole blocks, of which the even ones share no
/// node with each other, nor the odd ones: what elements add to their nodes can be added by all
/// even parts at the same time, then by all odd ones. The parts depend on the mesh alone, and so
/// does the order of every sum.
class ElementParts {
public:
  /// One part, in the order of the elements.
  explicit ElementParts(std::size_t elements = 0)
      : first_{0, (elements + elements_in_block - 1) / elements_in_block} {}
  /// As many as the mesh permits; one, where its elements are few or not numbered along a
  /// direction.
  template <int Dim>
  static ElementParts of(const mesh::Mesh<Dim>& mesh);

  std::size_t parts() const { return first_.size() - 1; }

  /// Calls use(part, first block, end of its blocks) for all parts, shared among the team lent to
  /// the thread.
  template <class Use>
  void for_each(const Use& use) const {
    const auto use_part = [&](std::size_t part) { use(part, first_[part], first_[part + 1]); };
    for_each_part((parts() + 1) / 2, [&](std::size_t pair) { use_part(2 * pair); });
    for_each_part(parts() / 2, [&](std::size_t pair) { use_part(2 * pair + 1); });
  }

private:
  template <int Dim>
  bool divide(const mesh::Mesh<Dim>& mesh) const;

  std::vector<std::size_t> first_;  ///< block of each part, and the end of the last one
};

}  // namespace dccast::mechanics
