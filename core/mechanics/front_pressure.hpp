#pragma once

#include "core/mechanics/mechanics_forms.hpp"
#include "core/mechanics/slab_state.hpp"

namespace dccast::mechanics {

/// Deviation of the liquid's pressure from the metallostatic one along the solidification front.
struct FrontPressure {
  double error = 0.0;  ///< [1] root mean square, relative; zero if there is no liquid
  int worst = -1;      ///< element with the largest contribution; -1 if there is none
};

/// A liquid at rest.
struct RestingLiquid {
  double specific_weight;  ///< [N/m3]
  double level;            ///< [m] height of its surface
};

template <int Dim>
FrontPressure front_pressure(const MechanicsForms<Dim>& forms, const mesh::Mesh<Dim>& mesh,
                             const SlabState<Dim>& state, const RestingLiquid& liquid);

extern template FrontPressure front_pressure(const MechanicsForms<2>&, const mesh::Mesh<2>&,
                                             const SlabState<2>&, const RestingLiquid&);
extern template FrontPressure front_pressure(const MechanicsForms<3>&, const mesh::Mesh<3>&,
                                             const SlabState<3>&, const RestingLiquid&);

}  // namespace dccast::mechanics
