#pragma once

#include <span>
#include <vector>

#include "core/mechanics/options.hpp"
#include "core/mechanics/step_outcome.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// The unknowns of a step: initial values on entry, the solution on return if it converges.
template <int Dim>
struct StepUnknowns {
  std::vector<double> displacement;        ///< by unknown [m]
  std::vector<char> contact;               ///< by contact unknown: closed
  std::vector<double> contact_multiplier;  ///< p of sbm by contact unknown [Pa]; else empty
  /// (element, point) stress deviator at the start of the step [Pa]; vnbm derives its parameters
  /// from it.
  std::vector<SymmetricTensor<Dim>> deviator;
};

/// The default algorithm: Newton's method with consistent tangent and a primal-dual active set in
/// the same loop. It is not in the paper.
template <int Dim>
StepOutcome solve_newton(const StepProblem<Dim>&, const Options&, Workspace&, StepUnknowns<Dim>&);
/// Paper section 4.2: Bermudez-Moreno with constant parameters for contact and creep.
template <int Dim>
StepOutcome solve_sbm(const StepProblem<Dim>&, const Options&, Workspace&, StepUnknowns<Dim>&);
/// Paper section 4.3: Newton for contact, eq. (74) for creep.
template <int Dim>
StepOutcome solve_nbm(const StepProblem<Dim>&, const Options&, Workspace&, StepUnknowns<Dim>&);
/// Paper section 4.4: Newton for contact, Bermudez-Moreno with parameters by element and step.
template <int Dim>
StepOutcome solve_vnbm(const StepProblem<Dim>&, const Options&, Workspace&, StepUnknowns<Dim>&);

/// Solves one step by the algorithm the options name. On success `unknowns` holds displacement,
/// contact set and stress deviator of the end of the step; otherwise it is unspecified.
template <int Dim>
StepOutcome solve_step(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
                       StepUnknowns<Dim>& unknowns);

}  // namespace dccast::mechanics
