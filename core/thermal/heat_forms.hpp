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
#include "core/thermal/growth.hpp"
#include "core/thermal/surface_shares.hpp"

namespace dccast::thermal {

/// What the heat solver knows of a mesh, which has any element and any dimension: where heat is
/// stored, how it is conducted, where it leaves. Areas and volumes are per metre in plane strain
/// [m, m2], per radian in an axisymmetric section [m2, m3], whole in a solid [m2, m3].
///
/// The stiffness is integrated with one point at each corner of an element, weighted by the
/// corner's share of the element's volume. On triangles and tetrahedra that is exact. On rectangles
/// and bricks it couples only nodes along their edges, which obeys a maximum principle whatever the
/// aspect ratio; the full integral does not once a cell is more than sqrt(2) times longer than
/// wide, and graded slab meshes have such cells. On oblique cells the gradients of the corners are
/// shifted by one vector, so that a linear field stays in equilibrium.
class HeatForms {
public:
  virtual ~HeatForms() = default;

  /// Takes the mesh as it is now: a new sparsity pattern if its elements changed, else only its
  /// coordinates. To be called before anything else is asked.
  /// @return true if the pattern is new
  virtual bool update() = 0;
  virtual int nodes() const = 0;

  const linalg::SparsityPattern& pattern() const { return pattern_; }
  /// Of unit conductivity, acting on the Kirchhoff function; pattern().entries() [1], [m] in 3D.
  std::span<const double> stiffness() const { return stiffness_; }
  /// Integral of each node's shape function (row sum of the mass matrix) [m^Dim], [m3/rad].
  const std::vector<double>& volume() const { return volume_; }
  const std::vector<int>& bottom_nodes() const { return bottom_nodes_; }
  /// Integral of the shape function over the bottom, by bottom node [m^(Dim-1)], [m2/rad].
  const std::vector<double>& bottom_weight() const { return bottom_weight_; }
  const std::vector<int>& top_nodes() const { return top_nodes_; }

  /// For the direct solver: what its orders depend on.
  virtual linalg::Geometry geometry() const = 0;
  virtual std::array<std::vector<int>, 2> fronts() const = 0;
  /// How the nodes lie where an extruded mesh of hexahedra has them in lines.
  virtual std::optional<mesh::Extrusion> extrusion() const = 0;

  /// Divides the side among nodes and laws: @see SideShare. @param shares  replaced; its storage is
  /// kept from step to step
  virtual void divide_side(const CoolingSpec& cooling, const SideInstant& instant,
                           std::vector<SideShare>& shares) const = 0;

  /// Takes the mesh after it has grown and carries nodal enthalpies over to it: see growth.hpp.
  /// @param nodes_per_row      nodes in a row of the structured mesh
  /// @param entering_enthalpy  [J/m3] of the metal poured
  /// @param enthalpy           (node) [J/m3], of the mesh before on entry, after on return
  /// @param new_pattern        as update() returns it
  virtual MetalEntry follow_growth(int nodes_per_row, double entering_enthalpy,
                                   std::vector<double>& enthalpy, bool& new_pattern) = 0;

  /// Takes the mesh after rows were merged and carries nodal enthalpies over to it: see
  /// row_merging.hpp. @param enthalpy  (node) [J/m3], of the mesh before on entry, after on return
  void follow_merging(const mesh::MergedRows& merged, std::vector<double>& enthalpy);

protected:
  linalg::SparsityPattern pattern_;
  std::vector<double> stiffness_;
  std::vector<double> volume_;
  std::vector<int> bottom_nodes_;
  std::vector<double> bottom_weight_;
  std::vector<int> top_nodes_;
};

/// The forms of a mesh, which must stay where it is.
std::unique_ptr<HeatForms> make_heat_forms(const mesh::Mesh<2>& mesh, mesh::SectionKind kind);
std::unique_ptr<HeatForms> make_heat_forms(
    const mesh::Mesh<3>& mesh, mesh::SectionKind kind = mesh::SectionKind::quarter_slab);

}  // namespace dccast::thermal
