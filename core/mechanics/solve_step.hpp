#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/stopwatch.hpp"
#include "core/linalg/direct_solver.hpp"
#include "core/linalg/secant_updates.hpp"
#include "core/linalg/two_grid.hpp"
#include "core/mechanics/options.hpp"
#include "core/mechanics/step_constraints.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// Wall time of the mechanics by task, summed over all steps so far.
struct CostSplit {
  double analysis = 0.0;        ///< [s] sparsity pattern and elimination order of new elements
  double stiffness = 0.0;       ///< [s] assembly of the tangents
  double forces = 0.0;          ///< [s] strains, return map, residual
  double preconditioner = 0.0;  ///< [s] factorisations and other preparation of solutions
  double solution = 0.0;        ///< [s] solutions by the factor or by conjugate gradients
  double contact = 0.0;         ///< [s] update of the contact set from gaps and reactions
};

/// Forces against which a residual is judged.
struct ForceScales {
  double acting = 0.0;     ///< [force] acting forces, before they cancel at the nodes
  double round_off = 0.0;  ///< [force] residual caused by round-off alone
};

/// Outcome of one step. Non-convergence is a result that drives the step control, not an exception.
struct [[nodiscard]] StepOutcome {
  /// False: the problem was not solved within the permitted iterations, or the matrix was singular.
  bool converged = false;
  /// Iterations of the algorithm, each with at least one residual.
  int iterations = 0;
  /// Iterations in which contact pairs opened or closed.
  int contact_changes = 0;
  /// Factorisations and solutions of the direct solver.
  int factorizations = 0;
  int solves = 0;
  int gradient_iterations = 0;  ///< of conjugate gradients, each with one preconditioner solve
  double equilibrium_residual = 0.0;     ///< [1] relative to the acting forces
  double constitutive_residual = 0.0;    ///< [1] relative; round-off where a return map is used
  std::vector<double> residual_history;  ///< [1] relative, by iteration
  /// Set if the step converged and the algorithm ended with an evaluation of the step problem
  /// itself: the residual in the workspace and the deviators then belong to the end of the step.
  std::optional<ForceScales> forces_at_end;
};

/// Objects kept between steps: the analysis of the factorisation and the work arrays, sized once
/// per mesh. [force] is [N/m] in 2D, [N/rad] if axisymmetric, [N] in 3D.
struct Workspace {
  /// Method and factor, chosen for the pattern of the mesh.
  linalg::DirectSolver solver;
  std::vector<double> stiffness;         ///< [force/m]
  std::vector<double> unheld_stiffness;  ///< [force/m] before any unknown was held
  std::vector<double> residual;          ///< [force]
  std::vector<double> direction;         ///< [m]
  std::vector<double> last_residual;     ///< [force] of the iteration before, for the secants
  std::vector<double> lifted;     ///< [force] caused by held unknowns that still have to move
  linalg::SecantUpdates secants;  ///< of the factor in `solver`
  bool is_solid = false;          ///< geometry of the mesh
  long gradient_iterations = 0;   ///< of conjugate gradients, total
  CostSplit cost;
  /// Replaces the factor if that would be too large.
  std::unique_ptr<linalg::TwoGrid<3>> two_grid;

  /// @param geometry  plane or solid; determines the ordering
  /// @param fronts    sets of unknowns from which an elimination may start
  void resize(const linalg::SparsityPattern& pattern, linalg::Geometry geometry,
              std::span<const std::vector<int>> fronts = {}) {
    if (two_grid == nullptr) solver.analyze(pattern, geometry, fronts);
    is_solid = geometry == linalg::Geometry::solid;
    stiffness.assign(pattern.entries(), 0.0);
    for (auto* v : {&residual, &direction, &lifted}) {
      v->assign(std::size_t(pattern.unknowns()), 0.0);
    }
    if (has_secants()) secants.resize(std::size_t(pattern.unknowns()));
  }

  /// Whether a kept factor learns from the iterations: that of a band in 3D, which is expensive.
  bool has_secants() const { return is_solid && two_grid == nullptr && solver.uses_band(); }
};

/// Runs the iterations of a step and records in its outcome how often the solver was used.
template <class Iterate>
void count_solver_use(const Workspace& work, StepOutcome& outcome, Iterate&& iterate) {
  const long factorizations = work.solver.factorizations(), solves = work.solver.solves(),
             gradients = work.gradient_iterations;
  iterate();
  outcome.factorizations = static_cast<int>(work.solver.factorizations() - factorizations);
  outcome.solves = static_cast<int>(work.solver.solves() - solves);
  outcome.gradient_iterations = static_cast<int>(work.gradient_iterations - gradients);
}

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
