#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <variant>

#include "tests/verification/mechanics/fixed_body.hpp"
#include "tests/verification/mechanics/paper_tests.hpp"

namespace dccast::verification {

/// The last residual of a step that is a number; zero if there is none.
inline double last_finite(const std::vector<double>& residuals) {
  const auto found =
      std::find_if(residuals.rbegin(), residuals.rend(), [](double r) { return std::isfinite(r); });
  return found == residuals.rend() ? 0.0 : *found;
}

/// Steps a body to `end`. `prepare(t)` sets loads and targets for the end of a step. A step that
/// does not converge is halved down to dt / 1024 and grows again afterwards, unless the run is
/// plain.
/// @return figures without errors, or the time and cause of the failure
template <class Element, class Prepare>
Result step_through(FixedBody<Element>& body, const TestRun& run, double end, Prepare&& prepare) {
  Figures figures;
  figures.elements = body.mesh.elements();
  figures.nodes = body.mesh.nodes();
  long iterations = 0, failed = 0;
  double dt = run.dt, t = 0.0, smallest = run.dt;
  const double start = cpu_seconds();

  while (t < end * (1.0 - 1e-12)) {
    const double step = std::min(dt, end - t);
    prepare(t + step);
    const auto outcome = body.step(run.options, step);
    iterations += outcome.iterations;

    if (!outcome.converged) {
      ++failed;
      dt = 0.5 * step;
      if (!run.cut_steps.value_or(!run.options.parameters.plain) || dt < run.dt / 1024.0) {
        char text[160];
        const bool finite = std::isfinite(outcome.equilibrium_residual);
        std::snprintf(
            text, sizeof text,
            "the step to t = %g s %s %d iterations; the last finite relative residual was %.2e",
            t + step, finite ? "did not converge in" : "diverged beyond all numbers after",
            outcome.iterations, last_finite(outcome.residual_history));
        return Failed{t + step, text};
      }
      continue;
    }

    t += step;
    smallest = std::min(smallest, step);
    ++figures.steps;
    dt = std::min(run.dt, 2.0 * dt);
  }

  figures.cpu_s = cpu_seconds() - start;
  figures.iterations_per_step =
      static_cast<double>(iterations) / static_cast<double>(figures.steps);
  figures.more["failed_attempts"] = static_cast<double>(failed);
  figures.more["smallest_step_s"] = smallest;
  figures.more["factorizations"] = static_cast<double>(body.work.solver.factorizations());
  return figures;
}

/// Adds the errors against exact fields to the figures of a run that did not fail.
template <class Element>
void add_errors(Result& result, const FixedBody<Element>& body,
                const std::function<Vector2(double, double)>& displacement,
                const std::function<PlaneStress(double, double)>& stress) {
  if (auto* figures = std::get_if<Figures>(&result)) {
    const Errors errors = relative_errors<Element>(body, displacement, stress);
    figures->displacement_error = errors.displacement;
    figures->stress_error = errors.stress;
    figures->more["stress_error_at_centroids"] = errors.stress_at_centroids;
    figures->displacement = body.displacement();
  }
}

/// Calls `run.operator()<Element>()` for the element family of a test run.
template <class Run>
Result with_element(mesh::ElementKind kind, Run&& run) {
  if (kind == mesh::ElementKind::p1) return run.template operator()<fem::P1Triangle>();
  if (kind == mesh::ElementKind::q1) return run.template operator()<fem::Q1Quadrilateral>();
  return run.template operator()<fem::BendingQuadrilateral>();
}

}  // namespace dccast::verification
