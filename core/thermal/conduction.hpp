#pragma once

#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::thermal {

/// Volume of every node: integral of its shape function (row sum of the mass matrix) [m2];
/// axisymmetric: times the radius [m3], 2 pi left out.
std::vector<double> nodal_volumes(const mesh::Mesh2D& mesh, mesh::SectionKind kind);

/// Geometry of heat conduction on a mesh: nodal volumes and the stiffness matrix of unit
/// conductivity, which acts on the Kirchhoff function.
///
/// The stiffness is integrated with one point at each corner of an element, weighted by the
/// corner's share of the element's volume. On triangles that is exact. On rectangles it gives the
/// five-point stencil, which obeys a maximum principle whatever their aspect ratio; the full
/// integral does not once a cell is more than sqrt(2) times longer than wide, and graded slab
/// meshes have such cells.
class Conduction {
public:
  /// Takes a mesh: a new sparsity pattern if its elements changed, else only its coordinates.
  /// @return true if the pattern is new
  bool set_mesh(const mesh::Mesh2D& mesh, mesh::SectionKind kind);

  const linalg::SparsityPattern& pattern() const { return pattern_; }
  std::span<const double> stiffness() const { return stiffness_; }  ///< pattern().entries() [1]
  const std::vector<double>& volume() const { return volume_; }     ///< by node [m2]
  int nodes() const { return static_cast<int>(volume_.size()); }

private:
  template <class Element>
  void integrate(const mesh::Mesh2D& mesh, mesh::SectionKind kind);

  linalg::SparsityPattern pattern_;
  std::vector<int> element_node_;
  std::vector<double> stiffness_;  ///< [1]
  std::vector<double> volume_;     ///< [m2]
};

}  // namespace dccast::thermal
