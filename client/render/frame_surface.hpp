#pragma once

#include <array>
#include <vector>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

using Vector3 = std::array<double, 3>;

double dot(const Vector3& a, const Vector3& b);
Vector3 cross(const Vector3& a, const Vector3& b);
Vector3 unit(const Vector3& a);

/// A face of an element that belongs to no other element.
struct SurfaceFace {
  std::vector<int> node;  ///< three or four, in order around the face
  Vector3 normal;         ///< outward in the undeformed slab, of length 1
};

/// Whether array sizes and node numbers of a frame of tetrahedra or hexahedra fit each other.
bool consistent_3d(const v1::Frame& frame);

/// Where the nodes are [m].
/// @param scale  factor on the displacements; 0 for the undeformed slab
std::vector<Vector3> places_of(const v1::Frame& frame, double scale);

/// The outer surface of a frame that is consistent in three dimensions.
std::vector<SurfaceFace> surface_of(const v1::Frame& frame);

/// The faces whose outward normal points this way.
/// @param least  smallest cosine of the angle between the normal and `direction`, of length 1
std::vector<SurfaceFace> facing(const std::vector<SurfaceFace>& surface, const Vector3& direction,
                                double least);

/// A round factor (1, 2, 5, 10, ...) that shows the curl of the butt and keeps the picture whole:
/// metal near the level may have moved much further than the bottom. In any dimension.
double displacement_scale(const v1::Frame& frame);

}  // namespace dccast::client::render
