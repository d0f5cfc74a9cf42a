#pragma once

#include <span>
#include <vector>

#include "core/base/symmetric_tensor.hpp"
#include "core/linalg/sparsity_pattern.hpp"
#include "core/mechanics/element_parts.hpp"
#include "core/mechanics/mechanics_forms.hpp"

namespace dccast::mechanics {

/// One time step of backward Euler, frozen: what every algorithm solves, and all it may know.
///
/// The law of an element is, with e the deviator and tr the trace of the strain of u minus the
/// inelastic strain of the step's start,
///     s + 2 mu dt kappa |s|^(q-2) s = 2 mu e,     p = bulk (tr - 3 thermal) + prestress,
/// stress = s + p I. An element of liquid metal is one without creep and with its own moduli. Find
/// u with the fixed unknowns at their targets, gaps and reactions of the contact unknowns not
/// negative, one of the two zero, and zero residual elsewhere: paper eq. (45) to (47) discretised
/// in time.
template <int Dim>
struct StepProblem {
  using Tensor = SymmetricTensor<Dim>;

  const MechanicsForms<Dim>* forms = nullptr;
  const linalg::SparsityPattern* pattern = nullptr;  ///< unknown = node * Dim + direction

  /// In which the elements are gone through; null: one after the other.
  const ElementParts* parts = nullptr;

  double dt = 0.0;        ///< [s]
  double exponent = 2.0;  ///< q [1], the same in all elements

  // By element.
  std::vector<double> bulk;       ///< [Pa]
  std::vector<double> shear;      ///< mu [Pa]
  std::vector<double> kappa;      ///< [Pa^-(q-1)/s], zero without creep
  std::vector<double> thermal;    ///< thermal stretch of the end of the step [1]
  std::vector<double> prestress;  ///< [Pa], negative in a liquid under pressure

  /// (element, point) strain that carries no stress: reference strain at solidification and
  /// viscoplastic strain up to the start of the step.
  std::vector<Tensor> inelastic;

  // By unknown.
  std::vector<double> external_force;  ///< [N/m] in 2D, [N/rad] if axisymmetric, [N] in 3D
  std::vector<char> fixed;             ///< not zero: held at `target`
  std::vector<double> target;          ///< [m]
  /// Stiffness of a spring towards zero [N/m2] in 2D, [N/(m rad)] if axisymmetric, [N/m] in 3D;
  /// empty where there is none.
  std::vector<double> spring;

  /// Unknowns whose gap may not become negative, frictionless: of the bottom, over the block
  /// (outward normal -x_last), then of sides along a wall.
  std::vector<int> contact;
  /// By contact unknown, +1 where it grows as the gap opens, -1 where it falls [1]; empty: all +1.
  std::vector<double> contact_sense;
  /// The last so many are of walls. The others carry the weight and are never all open.
  std::size_t walls = 0;
  /// By contact unknown, how far the block lies below it before anything has moved [m]; empty where
  /// the block is flat against the slab.
  std::vector<double> initial_gap;
  /// Share of the boundary that each stands for [m] in 2D, [m2/rad] if axisymmetric,
  /// [m2] in 3D.
  std::vector<double> contact_area;
  /// Force against which reactions are judged: the weight of the slab, in the unit of
  /// external_force.
  double weight = 0.0;

  std::size_t unknowns() const { return external_force.size(); }
  std::size_t carrying() const { return contact.size() - walls; }

  /// +1 or -1 [1], see contact_sense.
  double sense(std::size_t pair) const { return contact_sense.empty() ? 1.0 : contact_sense[pair]; }
  /// Where a contact unknown stands on the block or at the wall [m].
  double closed_at(std::size_t pair) const {
    return initial_gap.empty() ? 0.0 : -sense(pair) * initial_gap[pair];
  }
  /// Normal gap of a contact unknown at displacement `u` [m], open positive.
  double normal_gap(std::size_t pair, std::span<const double> u) const {
    return sense(pair) * (u[std::size_t(contact[pair])] - closed_at(pair));
  }
  /// How fast the gap opens along a vector of the unknowns, or by what force it is held, of a
  /// vector of forces, in the unit of the vector.
  double along_gap(std::size_t pair, std::span<const double> v) const {
    return sense(pair) * v[std::size_t(contact[pair])];
  }
};

}  // namespace dccast::mechanics
