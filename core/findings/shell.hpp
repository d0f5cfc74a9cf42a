#pragma once

#include <optional>
#include <span>

#include "core/findings/extreme.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// Smallest thickness of the shell between the bottom block and the melt: the length [m] of the
/// shortest path through it, and where that path begins at the bottom.
///
/// A path runs from node to node, from the bottom to the melt that is connected to the top (or to
/// the top itself). Its part in solid elements counts with its length, its part in liquid ones with
/// zero. In a 2D section it is the shortest cut that separates the symmetry plane from the faces:
/// the thickness is zero exactly if no path over edges of solid elements connects the two; solid
/// cells that touch only at a corner do not hold together. In 3D a hole does not separate the slab:
/// zero means that melt connected to the top stands on the block there.
///
/// @param solid  (element) carries stress
/// @return       empty if the mesh has no named bottom
template <int Dim>
std::optional<Extreme> thinnest_shell(const mesh::Mesh<Dim>& mesh, std::span<const char> solid);

/// Whether melt touches the bottom somewhere; if not, there is a shell of some thickness. Costs a
/// hundredth of thinnest_shell().
template <int Dim>
bool melt_touches_bottom(const mesh::Mesh<Dim>& mesh, std::span<const char> solid);

}  // namespace dccast::casting
