#pragma once

#include <array>
#include <functional>

#include "core/mesh/mesh.hpp"

namespace dccast::mechanics::testing {

using Vector3 = std::array<double, 3>;

/// A box of cells x, y, z, each a hexahedron or six tetrahedra. Its patches are x_low, x_high,
/// y_low, y_high, z_low and z_high, of the kinds of a quarter slab.
/// @param place  where the node of share (x, y, z) of the box stands, each from 0 to 1
mesh::Mesh3D box_mesh(const std::array<int, 3>& cells, bool tetrahedra,
                      const std::function<Vector3(const Vector3&)>& place);

}  // namespace dccast::mechanics::testing
