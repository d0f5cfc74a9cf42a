#include "core/mechanics/solve_step.hpp"

#include <stdexcept>

namespace dccast::mechanics {

template <class Element>
StepOutcome solve_step(const StepProblem<Element>& problem, const Options& options, Workspace& work,
                       StepUnknowns<Element>& unknowns) {
  switch (options.algorithm) {
    case Algorithm::newton:
      return solve_newton(problem, options, work, unknowns);
    case Algorithm::vnbm:
      return solve_vnbm(problem, options, work, unknowns);
    case Algorithm::sbm:
      return solve_sbm(problem, options, work, unknowns);
    case Algorithm::nbm:
      return solve_nbm(problem, options, work, unknowns);
  }
  throw std::logic_error("solve_step: an algorithm without a solver");
}

template StepOutcome solve_step(const StepProblem<fem::P1Triangle>&, const Options&, Workspace&,
                                StepUnknowns<fem::P1Triangle>&);
template StepOutcome solve_step(const StepProblem<fem::Q1Quadrilateral>&, const Options&,
                                Workspace&, StepUnknowns<fem::Q1Quadrilateral>&);
template StepOutcome solve_step(const StepProblem<fem::BendingQuadrilateral>&, const Options&,
                                Workspace&, StepUnknowns<fem::BendingQuadrilateral>&);
template StepOutcome solve_step(const StepProblem<fem::P1Ring>&, const Options&, Workspace&,
                                StepUnknowns<fem::P1Ring>&);
template StepOutcome solve_step(const StepProblem<fem::Q1Ring>&, const Options&, Workspace&,
                                StepUnknowns<fem::Q1Ring>&);
template StepOutcome solve_step(const StepProblem<fem::BendingRing>&, const Options&, Workspace&,
                                StepUnknowns<fem::BendingRing>&);

}  // namespace dccast::mechanics
