#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "core/mesh/mesh.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// The rounded corner between narrow and wide face of a quarter slab: an arc tangent to the narrow
/// face x = half_width and to the last straight piece of the opening.
struct CornerArc {
  using Point = std::array<double, 2>;

  double radius = 0.0;  ///< [m]
  Point centre{};       ///< [m]
  double angle = 0.0;   ///< [rad] from the normal of the narrow face to that of the wide face

  /// A point of the arc [m]. @param direction  [rad] from the normal of the narrow face
  Point point(double direction) const;
  /// Ends of the arc [m].
  Point on_narrow_face() const { return point(0.0); }
  Point on_wide_face() const { return point(angle); }
};

/// The arc of a section with a corner radius. @pre its opening is given at the half width
CornerArc corner_arc(const SectionSpec& spec);

/// Smallest number of cells of a corner along each face. With two, neighbouring chords differ by
/// less than 30 degrees, so that the mould holds each node along one normal.
inline constexpr int fewest_corner_cells = 2;

/// The base of an extruded mesh: a divided line in 2D, a plan of quadrilaterals in 3D.
template <int Dim>
struct Base {
  /// A cell is an interval in 2D, a quadrilateral in 3D.
  static constexpr int nodes_per_cell = Dim == 2 ? 2 : 4;

  /// A side of a base cell on which a wall stands.
  struct Piece {
    /// Number of the base cell.
    int cell = -1;
    /// Side of the cell: in 2D its left (0) or right (1) end; in 3D the side from corner k to
    /// corner k + 1.
    int side = 0;
  };
  /// A wall of the slab, given by the pieces of the rim on which it stands.
  struct Wall {
    std::string name;
    PatchKind kind = PatchKind::side;
    std::array<double, Dim> normal{};  ///< outward unit normal [1]
    std::vector<Piece> pieces;
  };

  std::vector<double> node;    ///< (node, Dim - 1) [m]
  std::vector<double> depth;   ///< (node) [m] of the block below its lip; empty: flat
  std::vector<int> cell_node;  ///< (cell, nodes_per_cell), in 3D counterclockwise from above
  std::vector<Wall> walls;

  /// Numbers of nodes and cells of the base.
  int nodes() const { return static_cast<int>(node.size()) / (Dim - 1); }
  int cells() const { return static_cast<int>(cell_node.size()) / nodes_per_cell; }
};

/// The two plans of a quarter slab. That of the heat divides the cells of the other one.
enum class Plan { mechanics, heat };

/// The base of a section's built-in mesh. In 2D from the symmetry plane to the side; of a quarter
/// slab the plan between the planes x = 0 and y = 0, with the nodes numbered along y first, which
/// keeps the bandwidth of the matrix small.
/// @param plan  of a quarter slab
template <int Dim>
Base<Dim> base_of(const SectionSpec& spec, Plan plan = Plan::mechanics);

/// The narrow face is the wall side_x, the wide face side_y, side_y_2, ... for each straight piece
/// of the opening, a rounded corner side_corner, side_corner_2, ... for each chord.
template <>
Base<2> base_of<2>(const SectionSpec& spec, Plan plan);
template <>
Base<3> base_of<3>(const SectionSpec& spec, Plan plan);

/// Ends of a piece of the rim [m], the first at the corner with the number of its side.
std::array<const double*, 2> ends_of(const Base<3>& plan, const Base<3>::Piece& piece);

/// Adds a piece of the rim to the walls of its name, of which each has one direction: to the one
/// with the direction of the piece, or to a new one. The walls are NAME, NAME_2, NAME_3 and so on.
/// @param first  index of the first wall with this name
void add_piece(Base<3>& base, std::size_t first, const std::string& name,
               const Base<3>::Piece& piece);

/// Extent in y of the plan of a quarter slab at a position x [m] along its wide face [m].
double reach_of(const Base<3>& plan, double x);

/// Distance of a place from the edge of the block, that of a section or of a quarter slab's plan
/// [m]: from the nearer face, along x or y; negative outside.
double distance_from_edge(const SectionSpec& spec, double x);
double distance_from_edge(const SectionSpec& spec, const Base<3>& plan, double x, double y);

/// Numbers of cells of a quarter slab's plan between the ends of its rounded corner, along the wide
/// and along the narrow face; zero without a corner radius.
std::array<int, 2> corner_cells(const SectionSpec& spec);

}  // namespace dccast::mesh
