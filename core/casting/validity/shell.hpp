#pragma once

#include <optional>
#include <span>

#include "core/casting/validity/extreme.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// The thinnest place of the shell between the bottom block and the melt: the length [m] of the
/// shortest way through it, and where that begins at the bottom.
///
/// A way runs from node to node, from the bottom to the melt that is connected to the top (or to
/// the top itself); what it crosses of a solid element counts with its length, a molten one is
/// free. In a section it is the shortest cut that separates the symmetry plane from the faces: the
/// thickness is zero exactly when no path over edges of solid elements joins the two, and two solid
/// cells that touch in a corner alone do not hold each other. In three dimensions a hole separates
/// nothing yet: zero means that melt connected to the top stands on the block there.
///
/// @param solid  (element) carries stress
/// @return       nothing for a mesh whose bottom is not named
template <int Dim>
std::optional<Extreme> thinnest_shell(const mesh::Mesh<Dim>& mesh, std::span<const char> solid);

/// Whether melt touches the bottom somewhere: where not, there is a shell, of whatever thickness.
/// Costs a hundredth of thinnest_shell().
template <int Dim>
bool melt_touches_bottom(const mesh::Mesh<Dim>& mesh, std::span<const char> solid);

}  // namespace dccast::casting
