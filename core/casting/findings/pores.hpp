#pragma once

#include <span>

#include "core/base/curve.hpp"
#include "core/material/alloy_card.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::casting {

/// Volume of the pores that unfed shrinkage leaves (docs/mush.md).
class Pores {
public:
  /// @param card  without the laws of the mush there are no pores
  Pores(const material::AlloyCard& card, mesh::SectionKind section);

  /// [m3/m] of a section, of a billet [m3/rad], of a quarter slab [m3].
  /// @param temperature  (node) [°C]
  template <int Dim>
  double volume(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature) const;

private:
  Curve share_;  ///< of the volume [1], against temperature; empty without the laws of the mush
  bool round_;
};

}  // namespace dccast::casting
