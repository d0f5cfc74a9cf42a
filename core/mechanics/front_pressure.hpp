#pragma once

#include "core/mechanics/mechanics_forms.hpp"
#include "core/mechanics/slab_state.hpp"

namespace dccast::mechanics {

/// How far the liquid is from the pressure of its depth, along its front with the solid.
struct FrontPressure {
  double error = 0.0;  ///< [1] root mean square, relative; zero without liquid
  int worst = -1;      ///< element with the largest share in it; -1 without one
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
