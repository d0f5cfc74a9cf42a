#pragma once

#include <span>
#include <vector>

#include "core/base/tensors.hpp"
#include "core/linalg/sparsity_pattern.hpp"
#include "core/mechanics/element_parts.hpp"
#include "core/mechanics/mechanics_forms.hpp"

namespace dccast::mechanics {

/// The problem of one backward-Euler time step: the only input of every algorithm.
///
/// The law of an element is, with e the deviator and tr the trace of the strain of u minus the
/// inelastic strain of the step's start,
///     s + 2 mu dt kappa |s|^(q-2) s = 2 mu e,     p = bulk (tr - 3 thermal) + prestress,
/// stress = s + p I. In cold metal |s| is limited by yielding. In the mush the skeleton creeps in
/// volume as well, driven by its effective mean stress p + melt_pressure; pressure and deviator
/// relax independently. An element of liquid metal has no creep and its own moduli. Find u such
/// that the fixed unknowns are at their targets, gaps and reactions of the contact unknowns are
/// non-negative and one of the two is zero, and the residual of all other unknowns is zero: paper
/// eq. (45) to (47) discretised in time.
template <int Dim>
struct StepProblem {
  using Tensor = SymmetricTensor<Dim>;

  /// Strains, forces and stiffness of the mesh; not owned.
  const MechanicsForms<Dim>* forms = nullptr;
  const linalg::SparsityPattern* pattern = nullptr;  ///< unknown = node * Dim + direction

  /// Parts in which the elements are processed; null: one part.
  const ElementParts* parts = nullptr;

  double dt = 0.0;        ///< [s]
  double exponent = 2.0;  ///< q [1], the same in all elements

  // By element.
  std::vector<double> bulk;              ///< [Pa]
  std::vector<double> shear;             ///< mu [Pa]
  std::vector<double> kappa;             ///< [Pa^-(q-1)/s], zero without creep
  std::vector<double> thermal;           ///< thermal stretch at the end of the step [1]
  std::vector<double> prestress;         ///< [Pa], negative in a liquid under pressure
  std::vector<double> volumetric_kappa;  ///< [Pa^-(q-1)/s] of the dilatation, zero except in mush
  std::vector<double> melt_pressure;     ///< [Pa] of the melt in the pores of the mush
  std::vector<double> linear_below;      ///< [Pa] mean stress below which that creep is linear
  /// Limit of |s|, sqrt(2/3) Y(T) [Pa], and its hardening w(T) [1]; empty: creep alone.
  std::vector<double> yield, hardening;

  /// (element, point) stress-free strain [1]: reference strain at solidification and viscoplastic
  /// strain up to the start of the step.
  std::vector<Tensor> inelastic;
  /// (element, point) equivalent strain that has hardened the metal, at the start of the step [1];
  /// empty without a yield limit.
  std::vector<double> hardened;

  // By unknown.
  std::vector<double> external_force;  ///< [N/m] in 2D, [N/rad] if axisymmetric, [N] in 3D
  std::vector<char> fixed;             ///< not zero: held at `target`
  std::vector<double> target;          ///< [m] of held unknowns and of springs
  /// Stiffness of a spring to the target [N/m2] in 2D, [N/(m rad)] if axisymmetric, [N/m] in
  /// 3D; empty if there are no springs.
  std::vector<double> spring;

  /// Unknowns with frictionless unilateral contact: at the bottom, above the block (outward normal
  /// -x_last), then where a side leans on the mould.
  std::vector<int> contact;
  /// By contact unknown: +1 if it increases as the gap opens, -1 if it decreases [1]; empty: all
  /// +1.
  std::vector<double> contact_sense;
  /// Number of wall contacts, which come last. The others carry the weight and are never all open.
  std::size_t walls = 0;
  /// By contact unknown: initial distance of the block below it [m]; empty if the block is flat and
  /// in contact everywhere.
  std::vector<double> initial_gap;
  /// By contact unknown: tributary area of the boundary [m] in 2D, [m2/rad] if axisymmetric, [m2]
  /// in 3D.
  std::vector<double> contact_area;
  /// Force against which reactions are judged: the weight of the slab [unit of external_force].
  double weight = 0.0;

  std::size_t unknowns() const { return external_force.size(); }
  std::size_t carrying() const { return contact.size() - walls; }

  /// +1 or -1 [1], see contact_sense.
  double sense(std::size_t pair) const { return contact_sense.empty() ? 1.0 : contact_sense[pair]; }
  /// Value of a contact unknown at which it touches the block or the wall [m].
  double closed_at(std::size_t pair) const {
    return initial_gap.empty() ? 0.0 : -sense(pair) * initial_gap[pair];
  }
  /// Normal gap of a contact unknown at displacement `u` [m]; positive if open [m].
  double normal_gap(std::size_t pair, std::span<const double> u) const {
    return sense(pair) * (u[std::size_t(contact[pair])] - closed_at(pair));
  }
  /// Component of a vector in the opening direction of a gap [unit of `v`]: the opening for a
  /// vector of displacements, the reaction for a vector of forces.
  double along_gap(std::size_t pair, std::span<const double> v) const {
    return sense(pair) * v[std::size_t(contact[pair])];
  }
};

}  // namespace dccast::mechanics
