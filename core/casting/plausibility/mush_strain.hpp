#pragma once

#include <span>

#include "core/casting/plausibility/bottom_shell.hpp"
#include "core/mechanics/slab_state.hpp"

namespace dccast::casting {

/// Largest tensile strain that metal between coherency and solidus has crept since coherency [1]:
/// the largest principal value of its viscoplastic strain, zero without such metal.
///
/// In plane strain the direction across the section is left out: it is held rigidly there, which no
/// slab is. Elastic strain, some 1e-4 in the mush, is left out too.
/// @param temperature  (node) [°C]
/// @param solidus      [°C]
/// @param growing      first element of the row that still stretches: it is the mesh's motion
/// @param hoop         the third component of 2D counts: a billet's strain around its axis
template <int Dim>
Located<Dim> mush_strain(const mesh::Mesh<Dim>& mesh, const mechanics::SlabState<Dim>& slab,
                         std::span<const double> temperature, double solidus, int growing,
                         bool hoop);

/// Largest principal value of a symmetric tensor in the plane or in space, in its unit.
double largest_principal(const SymmetricTensor<2>& in_plane);
double largest_principal(const SymmetricTensor<3>& tensor);

extern template Located<2> mush_strain(const mesh::Mesh<2>&, const mechanics::SlabState<2>&,
                                       std::span<const double>, double, int, bool);
extern template Located<3> mush_strain(const mesh::Mesh<3>&, const mechanics::SlabState<3>&,
                                       std::span<const double>, double, int, bool);

}  // namespace dccast::casting
