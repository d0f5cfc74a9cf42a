#pragma once

#include <span>
#include <vector>

#include "core/mechanics/options.hpp"
#include "core/mechanics/step_outcome.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// What a step changes: where it starts from, and where it ends when it converges.
template <class Element>
struct StepUnknowns {
  std::vector<double> displacement;  ///< by unknown [m]
  std::vector<char> contact;         ///< by contact unknown: closed
  std::vector<double> contact_multiplier;  ///< p of sbm by contact unknown [Pa]; empty elsewhere
  /// (element, point) stress deviator at the start of the step; vnbm takes its parameters from it.
  std::vector<SymmetricTensor<Element::dimension>> deviator;
};

/// Ours and the default: consistent-tangent Newton with a primal-dual active set in the same loop.
template <class Element>
StepOutcome solve_newton(const StepProblem<Element>&, const Options&, Workspace&,
                         StepUnknowns<Element>&);
/// Paper section 4.2: Bermudez-Moreno with constant parameters for contact and creep.
template <class Element>
StepOutcome solve_sbm(const StepProblem<Element>&, const Options&, Workspace&,
                      StepUnknowns<Element>&);
/// Paper section 4.3: Newton for contact, eq. (74) for creep.
template <class Element>
StepOutcome solve_nbm(const StepProblem<Element>&, const Options&, Workspace&,
                      StepUnknowns<Element>&);
/// Paper section 4.4: Newton for contact, Bermudez-Moreno with parameters by element and step.
template <class Element>
StepOutcome solve_vnbm(const StepProblem<Element>&, const Options&, Workspace&,
                       StepUnknowns<Element>&);

/// Solves one step by the algorithm the options name. On success `unknowns` holds displacement,
/// contact set and stress deviator of the end of the step; otherwise it is unspecified.
template <class Element>
StepOutcome solve_step(const StepProblem<Element>& problem, const Options& options,
                       Workspace& work, StepUnknowns<Element>& unknowns);

}  // namespace dccast::mechanics
