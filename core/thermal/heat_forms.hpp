#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/linalg/cholmod_solver.hpp"
#include "core/linalg/sparsity_pattern.hpp"
#include "core/mesh/extrusion.hpp"
#include "core/mesh/mesh.hpp"
#include "core/thermal/cooling_spec.hpp"
#include "core/thermal/growth.hpp"

namespace dccast::thermal {

/// The part of the boundary that belongs to one node and one cooling law.
///
/// Facets are cut at every zone edge, at the water line and at the kinks of tables against
/// distance, and the shape functions are integrated exactly over the pieces, so that the result
/// depends continuously on every edge. Below the water line, running water takes precedence;
/// otherwise the first zone of the face that covers the piece applies; otherwise the side is dry.
/// In an axisymmetric section everything is weighted by the radius, without 2 pi.
///
/// At an edge of a solid the two faces share only nodes: each facet is cooled by the law of its own
/// face, and a node on the edge has shares of both. No area is counted twice or left out.
struct SideShare {
  int node = 0;
  int law = 0;  ///< index of the zone, or `law_water`, `law_dry`
  /// Integral of the node's shape function [m]; axisymmetric: times r [m2]; solid: [m2].
  double weight = 0.0;
  double distance = 0.0;  ///< [m] below the metal level where the law is evaluated
  Face face = Face::wide;
};
inline constexpr int law_water = -1;
inline constexpr int law_dry = -2;

/// Data that determine the cooling law of each place at one time.
struct SideInstant {
  double mould_level = 0.0;              ///< [m] from which distances are counted
  std::array<bool, faces> water_runs{};  ///< by face
  /// (node) [m] vertical displacement of the side; empty: zero.
  std::span<const double> rise{};
  bool second_water_runs = false;
  double above = 0.0;  ///< [m] by which the metal stands higher than that level
};

/// The cooling law of a place.
struct LawAt {
  int number = law_dry;
  bool by_distance = false;  ///< the law is a table against distance
};

/// The cooling laws of the side at one time.
class SideLaws {
public:
  /// @param cooling  must outlive this object
  SideLaws(const CoolingSpec& cooling, const SideInstant& instant);
  /// Distances below the metal level at which a law may change or has a kink [m], ascending.
  const std::vector<double>& edges() const { return edges_; }
  /// @param distance  [m] below the metal level
  LawAt at(double distance, Face face) const;

private:
  /// The uppermost zone follows a level that rises: it ends where the metal does.
  double upper_edge(const SideZone& zone) const { return zone.from > 0.0 ? zone.from : -above_; }

  const CoolingSpec& cooling_;
  std::array<bool, faces> water_runs_;
  bool second_water_runs_;
  double above_;               ///< [m]
  std::vector<double> edges_;  ///< [m]
};

/// Two neighbours at the bottom, by their numbers among the bottom nodes.
struct BottomPath {
  std::size_t first = 0, second = 0;
  double length = 0.0;  ///< [m]
};

/// The mesh as the heat solver sees it, for any element and dimension: heat capacity, conduction
/// and boundary. Areas and volumes are per metre in plane strain [m, m2], per radian in an
/// axisymmetric section [m2, m3], totals in a solid [m2, m3].
///
/// The stiffness is integrated with one point at each corner of an element, weighted by the
/// corner's share of the volume of the element. On triangles and tetrahedra this is exact. On
/// rectangles and bricks it couples nodes along the edges only and satisfies a maximum principle at
/// any aspect ratio; full integration violates it once a cell is more than sqrt(2) times longer
/// than wide, and graded slab meshes have such cells. On oblique cells the gradients at the corners
/// are shifted by one vector, so that a linear field remains in equilibrium.
class HeatForms {
public:
  virtual ~HeatForms() = default;

  /// Updates the forms after a change of the mesh: the sparsity pattern if its elements changed,
  /// else only the coordinates. Must be called before any other function.
  /// @return true if the pattern is new
  virtual bool update() = 0;
  /// Size of the mesh; unknowns of the heat are its nodes.
  virtual int nodes() const = 0;

  const linalg::SparsityPattern& pattern() const { return pattern_; }
  /// Stiffness for unit conductivity, acting on the Kirchhoff function: (entry of pattern()) [1],
  /// [m] in 3D.
  std::span<const double> stiffness() const { return stiffness_; }
  /// Integral of each node's shape function (row sum of the mass matrix) [m^Dim], [m3/rad].
  const std::vector<double>& volume() const { return volume_; }
  const std::vector<int>& bottom_nodes() const { return bottom_nodes_; }
  /// Integral of the shape function over the bottom, by bottom node [m^(Dim-1)], [m2/rad].
  const std::vector<double>& bottom_weight() const { return bottom_weight_; }
  /// (bottom node) [m] place in the plan; y is 0 in a section.
  const std::vector<std::array<double, 2>>& bottom_places() const { return bottom_places_; }
  const std::vector<int>& top_nodes() const { return top_nodes_; }
  /// Integral of the shape function over the top, by top node [m^(Dim-1)], [m2/rad].
  const std::vector<double>& top_weight() const { return top_weight_; }
  /// Neighbours at the bottom: edges and diagonals of its facets, each once.
  const std::vector<BottomPath>& bottom_paths() const { return bottom_paths_; }
  /// (node) column of the side to which a node belongs, -1 elsewhere: the nodes above each other,
  /// or all of a side that has no such columns.
  const std::vector<int>& side_column() const { return side_column_; }

  /// Input of the direct solver's ordering.
  virtual linalg::Geometry geometry() const = 0;
  /// Nodes along two edges, from which an elimination may start.
  virtual std::array<std::vector<int>, 2> fronts() const = 0;
  /// The lines and rows of nodes of an extruded mesh of hexahedra; empty for other meshes.
  virtual std::optional<mesh::Extrusion> extrusion() const = 0;

  /// Divides the side among nodes and cooling laws, @see SideShare. @param shares  overwritten; an
  /// output argument, so that its memory is reused between steps
  /// @return  height of the side [m]
  virtual double divide_side(const CoolingSpec& cooling, const SideInstant& instant,
                             std::vector<SideShare>& shares) const = 0;

  /// Updates the forms after growth of the mesh and transfers the nodal enthalpies, see growth.hpp.
  /// @param nodes_per_row      nodes per row of the structured mesh
  /// @param entering_enthalpy  [J/m3] of the metal poured
  /// @param enthalpy           (node) [J/m3], on the old mesh on entry, on the new one on return
  /// @param new_pattern        set to what update() returns
  virtual MetalEntry follow_growth(int nodes_per_row, double entering_enthalpy,
                                   std::vector<double>& enthalpy, bool& new_pattern) = 0;

  /// Updates the forms after rows were merged and transfers the nodal enthalpies, see
  /// row_merging.hpp.
  /// @param enthalpy  (node) [J/m3], on the old mesh on entry, on the new one on return
  void follow_merging(const mesh::MergedRows& merged, std::vector<double>& enthalpy);

protected:
  linalg::SparsityPattern pattern_;
  std::vector<double> stiffness_;  ///< @see stiffness() [1], [m] in 3D
  std::vector<double> volume_;     ///< (node) [m^Dim], [m3/rad]
  std::vector<int> bottom_nodes_;
  std::vector<double> bottom_weight_;                 ///< (bottom node) [m^(Dim-1)], [m2/rad]
  std::vector<std::array<double, 2>> bottom_places_;  ///< (bottom node) [m]
  std::vector<BottomPath> bottom_paths_;
  std::vector<int> top_nodes_;
  std::vector<double> top_weight_;  ///< (top node) [m^(Dim-1)], [m2/rad]
  std::vector<int> side_column_;    ///< (node)
};

/// Creates the forms of a mesh, which must not move in memory.
std::unique_ptr<HeatForms> make_heat_forms(const mesh::Mesh<2>& mesh, mesh::SectionKind kind);
std::unique_ptr<HeatForms> make_heat_forms(
    const mesh::Mesh<3>& mesh, mesh::SectionKind kind = mesh::SectionKind::quarter_slab);

}  // namespace dccast::thermal
