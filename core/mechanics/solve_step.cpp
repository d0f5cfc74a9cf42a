#include "core/mechanics/solve_step.hpp"

#include <stdexcept>

namespace dccast::mechanics {

template <int Dim>
StepOutcome solve_step(const StepProblem<Dim>& problem, const Options& options, Workspace& work,
                       StepUnknowns<Dim>& unknowns) {
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

template StepOutcome solve_step(const StepProblem<2>&, const Options&, Workspace&,
                                StepUnknowns<2>&);
template StepOutcome solve_step(const StepProblem<3>&, const Options&, Workspace&,
                                StepUnknowns<3>&);

}  // namespace dccast::mechanics
