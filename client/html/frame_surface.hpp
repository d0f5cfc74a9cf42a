#pragma once

#include <array>
#include <optional>
#include <vector>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// A point or a direction [m], or a unit vector [1].
using Vector3 = std::array<double, 3>;

/// Scalar product [product of the units].
double dot(const Vector3& a, const Vector3& b);
/// Products of vectors; unit() keeps the direction and sets the length to 1.
Vector3 cross(const Vector3& a, const Vector3& b);
Vector3 unit(const Vector3& a);

/// A face of an element that belongs to no other element.
struct SurfaceFace {
  std::vector<int> node;  ///< three or four, in order around the face
  Vector3 normal;         ///< outward unit normal in the undeformed slab [1]
};

/// Whether array sizes and node numbers of a frame are consistent: of triangles and quadrilaterals
/// in 2D, of tetrahedra and hexahedra in 3D.
bool is_consistent(const v1::Frame& frame, int dimension);

/// Displacement as it is drawn, (node, coordinate) [m]; empty if the frame has none. Liquid stands
/// level: its own displacement, that of a mesh which follows the shell, has no meaning. Above the
/// front the vertical displacement falls linearly from that of the front to zero at the metal
/// level; liquid with no node of the solid straight below it is drawn where it is poured.
std::vector<double> drawn_displacement(const v1::Frame& frame);

/// The nodes of a frame in three dimensions, undeformed [m].
std::vector<Vector3> places_of(const v1::Frame& frame);

/// The outer surface of a frame that is consistent in three dimensions.
std::vector<SurfaceFace> surface_of(const v1::Frame& frame);

/// The visible part of a frame: all elements of a 2D section, the outer surface of a quarter slab.
struct FrameSkin {
  std::vector<std::vector<int>> faces;    ///< nodes in order; in 3D anticlockwise from outside
  std::vector<std::array<int, 2>> edges;  ///< of the outline; in 3D the sharp edges of the surface
};

/// @return empty if the arrays of the frame are inconsistent
std::optional<FrameSkin> skin_of(const v1::Frame& frame);

}  // namespace dccast::client::render
