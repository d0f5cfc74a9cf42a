#pragma once

#include <span>
#include <vector>

#include "core/mechanics/options.hpp"
#include "core/mechanics/step_outcome.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// What a step changes: where it starts from, and where it ends when it converges.
template <int Dim>
struct StepUnknowns {
  std::vector<double> displacement;  ///< by unknown [m]
  std::vector<char> contact;         ///< by contact unknown: closed
  std::vector<double> contact_multiplier;  ///< p of sbm by contact unknown [Pa]; empty elsewhere
  /// (element, point) stress deviator at the start of the step; vnbm takes its parameters from it.
  std::vector<SymmetricTensor<Dim>> deviator;
};

/// Ours and the default: consistent-tangent Newton with a primal-dual active set in the same loop.
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
