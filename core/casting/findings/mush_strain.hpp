#pragma once

#include <span>

#include "core/base/tensors.hpp"
#include "core/casting/findings/shell.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// Largest tensile viscoplastic strain of the mush since coherency [1]: the largest principal value
/// in metal that is coherent and hotter than `fragile_above`; zero without such metal.
///
/// In plane strain the out-of-plane direction is left out: the model constrains it rigidly, a real
/// slab does not. Elastic strain, about 1e-4 in the mush, is left out too.
/// @param temperature    (element) mean [°C]
/// @param fragile_above  [°C] colder metal is tough
/// @param growing        first element of the row that still stretches, whose motion is that of the
///                       mesh
/// @param hoop           include the out-of-plane component in 2D: the hoop strain of a billet
template <int Dim>
Located<Dim> mush_strain(const mesh::Mesh<Dim>& mesh, const mechanics::SlabState<Dim>& slab,
                         std::span<const double> temperature, double fragile_above, int growing,
                         bool hoop);

/// Largest principal value of a symmetric tensor in 2D or 3D [unit of the tensor].
double largest_principal(const SymmetricTensor<2>& in_plane);
double largest_principal(const SymmetricTensor<3>& tensor);  ///< [unit of the tensor]

}  // namespace dccast::casting
