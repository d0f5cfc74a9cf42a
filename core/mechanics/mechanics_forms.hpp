#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/base/tensors.hpp"
#include "core/fem/facet_pieces.hpp"
#include "core/linalg/sparsity_pattern.hpp"
#include "core/mechanics/element_parts.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::mechanics {

/// Local directions of the unknowns of a node, so that a support along the normal of an oblique
/// face holds a single unknown.
template <int Dim>
struct NodalFrame {
  int node;
  std::array<std::array<double, Dim>, Dim> axis;  ///< by unknown, orthonormal [1]

  using Vector = std::array<double, Dim>;
  /// Transforms components along the unknowns to components along the coordinate axes [unit of the
  /// vector].
  Vector to_coordinates(const Vector& along) const {
    Vector v{};
    for (std::size_t k = 0; k < std::size_t(Dim); ++k) {
      for (std::size_t a = 0; a < std::size_t(Dim); ++a) v[a] += axis[k][a] * along[k];
    }
    return v;
  }
  /// Transforms components along the coordinate axes to components along the unknowns [unit of the
  /// vector].
  Vector to_frame(const Vector& v) const {
    Vector along{};
    for (std::size_t k = 0; k < std::size_t(Dim); ++k) {
      for (std::size_t a = 0; a < std::size_t(Dim); ++a) along[k] += axis[k][a] * v[a];
    }
    return along;
  }
};

/// The elements of a mesh as the algorithms of mechanics see them: strains of a displacement,
/// forces of a stress, stiffness of a tangent.
///
/// Units: displacements [m]; forces [N/m] in plane strain, [N/rad] in an axisymmetric section, [N]
/// in a solid.
///
/// Displacements and forces are arrays by unknown, Dim per node: along the coordinate axes, or
/// along the axes of the node's frame.
///
/// Arrays by point are ordered within a block by place_in_block(); arrays by element hold the
/// elements_in_block elements of a block. Unused places may hold any finite value.
template <int Dim>
class MechanicsForms {
public:
  using Tensor = SymmetricTensor<Dim>;
  using Mesh = mesh::Mesh<Dim>;
  /// (point) of an element; those beyond its last point are zero.
  using PointTensors = std::array<Tensor, 1 << Dim>;

  virtual ~MechanicsForms() = default;

  /// Sets the mesh, or updates its coordinates. The mesh must not move in memory.
  /// @param first  first element that is new or has moved
  virtual void update(const Mesh& mesh, std::size_t first = 0) = 0;
  /// Sets the local frames of some nodes; all others have none. They are kept until the next call,
  /// or until a mesh with another number of elements is set.
  virtual void set_frames(std::span<const NodalFrame<Dim>> frames) = 0;
  /// Rotates the axes of the solid elements with the mean displacement gradient of each element.
  /// From now on the rotation is removed from the displacements of an element, and its strains,
  /// forces and stiffness refer to its own axes. Kept until the next call or update().
  /// @param displacement  by unknown [m]
  /// @param solid         (element) not zero: the axes follow the rotation
  /// @throws std::logic_error of axisymmetric elements
  virtual void set_rotations(std::span<const double> displacement, std::span<const char> solid) = 0;
  /// Leaves elements out: they add neither forces nor stiffness. Kept until the next call or
  /// update(). @param elements  (element) not zero: it takes part; empty: all do
  virtual void set_taking_part(std::span<const char> elements) = 0;
  virtual std::size_t elements() const = 0;
  virtual std::size_t points() const = 0;  ///< of an element

  /// Computes the strain deviator [1] at every point and the mean dilatation [1] of every element
  /// from a displacement [m].
  virtual void strains(ElementBlock block, std::span<const double> displacement,
                       TensorBlock<Dim> deviator, std::span<double> dilatation) const = 0;
  /// Adds the nodal forces of the stress deviators and mean normal stresses at the points [Pa] to
  /// `force` [N/m], axisymmetric [N/rad], of a solid [N].
  /// @param squares  sum to which the squares of all element forces are added
  virtual void add_forces(ElementBlock block, TensorBlock<Dim> stress,
                          std::span<const double> pressure, std::span<double> force,
                          double& squares) const = 0;
  /// Adds the stiffness of the responses at the points and of the bulk moduli of the elements
  /// [Pa] to `values`: force by displacement.
  virtual void add_stiffness(ElementBlock block, ResponseBlock<Dim> response,
                             std::span<const double> bulk, const linalg::SparsityPattern& pattern,
                             std::span<double> values) const = 0;

  /// Strains at the points of an element [1], with its mean dilatation as their trace.
  virtual PointTensors strains(std::size_t element, std::span<const double> displacement) const = 0;
  /// The strain at one point [1]; costs as much as those at all points.
  Tensor strain(std::size_t element, std::size_t point,
                std::span<const double> displacement) const {
    return strains(element, displacement)[point];
  }
  /// Mean dilatation of an element [1] for a displacement [m].
  virtual double mean_dilatation(std::size_t element,
                                 std::span<const double> displacement) const = 0;

  virtual double volume(std::size_t element) const = 0;  ///< [m^Dim], axisymmetric: [m3/rad]
  /// Sum of the squares of the nodal forces caused by a mean normal stress [Pa] in every element.
  virtual double squared_forces(std::span<const double> stress) const = 0;
  /// Subtracts the weight of the elements from the forces, along the last coordinate axis.
  /// @param specific_weight  by element [N/m3]
  /// @return                 total weight
  virtual double subtract_weight(std::span<const double> specific_weight,
                                 std::span<double> force) const = 0;
  /// Adds the forces of a pressure that is linear over a facet and pushes against it from outside.
  /// @param pressure  (node of the facet) [Pa]
  /// @return          their resultant along the last coordinate axis
  virtual double add_pressure(const mesh::Facet<Dim>& facet, std::span<const double> pressure,
                              std::span<double> force) const = 0;
  /// Integrals of the shape functions of a facet [m^(Dim-1)], axisymmetric: [m2/rad].
  virtual fem::FacetShares<Dim> facet_shares(const mesh::Facet<Dim>& facet) const = 0;
};

/// Creates the forms of a 2D section.
std::unique_ptr<MechanicsForms<2>> make_mechanics_forms(mesh::ElementKind element,
                                                        mesh::SectionKind section);
/// Creates the forms of a solid: tetrahedra or hexahedra.
std::unique_ptr<MechanicsForms<3>> make_solid_forms(mesh::ElementKind element);

}  // namespace dccast::mechanics
