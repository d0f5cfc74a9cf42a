#pragma once

#include <array>
#include <optional>
#include <vector>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

using Vector3 = std::array<double, 3>;

/// Scalar product [product of the units].
double dot(const Vector3& a, const Vector3& b);
Vector3 cross(const Vector3& a, const Vector3& b);
Vector3 unit(const Vector3& a);

/// A face of an element that belongs to no other element.
struct SurfaceFace {
  std::vector<int> node;  ///< three or four, in order around the face
  Vector3 normal;         ///< outward unit normal in the undeformed slab [1]
};

/// Whether array sizes and node numbers of a 2D frame are consistent.
bool consistent(const v1::Frame& frame);

/// Whether array sizes and node numbers of a frame of tetrahedra or hexahedra are consistent.
bool consistent_3d(const v1::Frame& frame);

/// Displacement as it is drawn, (node, coordinate) [m]; empty if the frame has none. Liquid stands
/// level: its own displacement, that of a mesh which follows the shell, has no meaning. Above the
/// front the vertical displacement falls linearly from that of the front to zero at the metal
/// level; liquid with no node of the solid straight below it is drawn where it is poured.
std::vector<double> drawn_displacement(const v1::Frame& frame);

/// Positions of the nodes [m].
/// @param scale  magnification of the displacements [1]; 0 for the undeformed slab
std::vector<Vector3> places_of(const v1::Frame& frame, double scale);

/// The outer surface of a frame that is consistent in three dimensions.
std::vector<SurfaceFace> surface_of(const v1::Frame& frame);

/// The faces whose outward normal points in a direction.
/// @param direction  unit vector [1]
/// @param least      smallest cosine of the angle between normal and direction [1]
std::vector<SurfaceFace> facing(const std::vector<SurfaceFace>& surface, const Vector3& direction,
                                double least);

/// A round magnification (1, 2, 5, 10, ...) of the displacements [1] that makes the butt curl
/// visible without distorting the rest of the picture: metal near the level may have moved much
/// further than the bottom. For any dimension.
double displacement_scale(const v1::Frame& frame);

/// Projection of a picture. The horizontal coordinate in the view box is across[0] x + across[1] y
/// + across[2] z + across[3], the vertical one likewise with `down`, where x, y, z [m] include the
/// magnified displacement; a 2D section has no z.
struct PictureView {
  std::array<double, 4> across{}, down{};  ///< [1/m] and, the last one, [1]; in view box units
  Vector3
      to_viewer{};  ///< direction to the viewer [1], decides which faces hide others; zero in 2D
};

/// The range of temperatures that the colours of a picture cover [°C].
struct ColourRange {
  double low = 0.0, high = 1.0;  ///< [°C]
};

/// The visible part of a frame: all elements of a 2D section, the outer surface of a quarter slab.
struct FrameSkin {
  std::vector<std::vector<int>> faces;    ///< nodes in order; in 3D anticlockwise from outside
  std::vector<std::array<int, 2>> edges;  ///< of the outline; in 3D the sharp edges of the surface
};

/// Edges between faces that meet at more than 45 degrees in the undeformed slab.
std::vector<std::array<int, 2>> creases_of(const std::vector<SurfaceFace>& surface);

/// @return empty if the arrays of the frame are inconsistent
std::optional<FrameSkin> skin_of(const v1::Frame& frame);

}  // namespace dccast::client::render
