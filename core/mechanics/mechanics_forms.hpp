#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/base/symmetric_tensor.hpp"
#include "core/fem/facet_geometry.hpp"
#include "core/linalg/sparsity_pattern.hpp"
#include "core/mechanics/point_block.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::mechanics {

/// Directions of the unknowns of a node that are not the coordinate axes, so that what holds a body
/// along an oblique face is one unknown held.
template <int Dim>
struct NodalFrame {
  int node;
  std::array<std::array<double, Dim>, Dim> axis;  ///< by unknown, orthogonal unit vectors

  using Vector = std::array<double, Dim>;
  /// Along the coordinate axes, from components along the unknowns.
  Vector to_coordinates(const Vector& along) const {
    Vector v{};
    for (std::size_t k = 0; k < std::size_t(Dim); ++k) {
      for (std::size_t a = 0; a < std::size_t(Dim); ++a) v[a] += axis[k][a] * along[k];
    }
    return v;
  }
  /// Along the unknowns, from components along the coordinate axes.
  Vector to_frame(const Vector& v) const {
    Vector along{};
    for (std::size_t k = 0; k < std::size_t(Dim); ++k) {
      for (std::size_t a = 0; a < std::size_t(Dim); ++a) along[k] += axis[k][a] * v[a];
    }
    return along;
  }
};

/// What the algorithms of mechanics know of the elements of a mesh: strains of a displacement,
/// forces of a stress, stiffness of a tangent. Forces are per metre in plane strain, per radian in
/// an axisymmetric section.
///
/// Displacements and forces are by unknown, Dim of each node: along the coordinate axes, or those
/// of the frame of the node.
///
/// Arrays by point hold the points of a block as place_in_block() says, arrays by element its
/// elements_in_block elements; places without an element may hold anything finite.
template <int Dim>
class MechanicsForms {
public:
  using Tensor = SymmetricTensor<Dim>;
  using Mesh = mesh::Mesh<Dim>;

  virtual ~MechanicsForms() = default;

  /// Takes a mesh, which must stay where it is, or its new coordinates.
  /// @param first  first element that is new or has moved
  virtual void update(const Mesh& mesh, std::size_t first = 0) = 0;
  /// Gives nodes frames of their own; all others have none. They are kept until the next call or a
  /// mesh with another number of elements.
  virtual void set_frames(std::span<const NodalFrame<Dim>> frames) = 0;
  /// Turns the axes of the solid elements with them: from here on an element sees a displacement
  /// less the rotation that its mean gradient has here, and strains, forces and stiffness are those
  /// of its own axes. Kept until the next call or update().
  /// @param displacement  by unknown [m] @param solid  (element) not zero: follows its rotation
  /// @throws std::logic_error of axisymmetric elements
  virtual void set_rotations(std::span<const double> displacement, std::span<const char> solid) = 0;
  virtual std::size_t elements() const = 0;
  virtual std::size_t points() const = 0;  ///< of an element

  /// Deviator of the strain [1] at every point and mean dilatation [1] of every element, of a
  /// displacement [m].
  virtual void strains(ElementBlock block, std::span<const double> displacement,
                       TensorBlock<Dim> deviator, std::span<double> dilatation) const = 0;
  /// Adds the nodal forces of the stress deviators and mean normal stresses at the points [Pa] to
  /// `force` [N/m], axisymmetric [N/rad], of a solid [N].
  /// @param squares  gets the squares of all element forces added
  virtual void add_forces(ElementBlock block, TensorBlock<Dim> stress,
                          std::span<const double> pressure, std::span<double> force,
                          double& squares) const = 0;
  /// Adds the stiffness of the responses at the points and of the bulk moduli of the elements
  /// [Pa] to `values`: force by displacement.
  virtual void add_stiffness(ElementBlock block, ResponseBlock<Dim> response,
                             std::span<const double> bulk, const linalg::SparsityPattern& pattern,
                             std::span<double> values) const = 0;

  /// Strain at a point of an element [1], its trace the mean dilatation of the element.
  virtual Tensor strain(std::size_t element, std::size_t point,
                        std::span<const double> displacement) const = 0;
  /// [1] of a displacement [m]
  virtual double mean_dilatation(std::size_t element,
                                 std::span<const double> displacement) const = 0;

  virtual double volume(std::size_t element) const = 0;  ///< [m^Dim], axisymmetric: [m3/rad]
  /// Sum of the squares of the nodal forces of a mean normal stress [Pa] in every element.
  virtual double squared_forces(std::span<const double> stress) const = 0;
  /// Subtracts the weight of the elements from the forces, along the last coordinate axis.
  /// @param specific_weight  by element [N/m3]
  /// @return                 the whole weight
  virtual double subtract_weight(std::span<const double> specific_weight,
                                 std::span<double> force) const = 0;
  /// Integrals of the shape functions of a facet [m^(Dim-1)], axisymmetric: [m2/rad].
  virtual fem::FacetShares<Dim> facet_shares(const mesh::Facet<Dim>& facet) const = 0;
};

/// The forms of the element of a section.
std::unique_ptr<MechanicsForms<2>> make_mechanics_forms(mesh::ElementKind element,
                                                        mesh::SectionKind section);
/// The forms of the element of a solid: tetrahedra or hexahedra.
std::unique_ptr<MechanicsForms<3>> make_solid_forms(mesh::ElementKind element);

}  // namespace dccast::mechanics
