#pragma once

#include "core/mesh/mesh.hpp"

namespace dccast::mesh {

/// The corner of its cell at which a facet of a flat mesh of quadrilaterals begins.
int first_corner(const Mesh<2>& mesh, const Facet<2>& facet);

/// Divides every cell of a flat mesh of quadrilaterals into `parts` by `parts` cells, evenly along
/// its sides, and the facets of its patches with them. The nodes keep their numbers, new ones
/// follow.
Mesh<2> divided(const Mesh<2>& coarse, int parts);

}  // namespace dccast::mesh
