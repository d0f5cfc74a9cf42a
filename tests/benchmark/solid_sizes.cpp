// Cost of a quarter slab against its size: the hold and the first steps of start-3d on meshes of
// one shape, each in a process of its own, so that its peak of memory is its own.
//
//   dccast-solid-sizes [SCALE ...]    cells along each direction, times those of engineering
//   quality
//
// One line a mesh: seconds of the processor of a mechanical step, by part.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "core/casting/slab_run.hpp"
#include "tests/support/load_case.hpp"

namespace {

using namespace dccast;

struct Request {
  std::vector<double> scales;
  double end = 10.0;  // [s] of casting
  bool by_factors = false;
};

/// 11 x 5 x 22 cells of engineering quality, all divided alike.
casting::Case case_of(double scale, const Request& request) {
  casting::Case c = support::load_case("start-3d");
  const auto cells = [scale](double n) { return static_cast<int>(std::lround(n * scale)); };
  c.section.columns = cells(11);
  c.section.layers = cells(5);
  c.section.heat_cells = {};
  c.section.rows = cells(22);
  c.section.side_cell = c.section.wide_side_cell = 12e-3 / scale;
  c.section.bottom_cell = 3e-3 / scale;
  c.section.growth_cell = 5e-3 / scale;
  c.time.end = request.end;
  if (request.by_factors) {
    c.mechanics.options.two_grids_from_unknowns = std::numeric_limits<int>::max();
  }
  c.time.step =
      Curve(Abscissa::time, {-60.0, -55.0, -54.999, -0.001, 0.0, 2.0, 2.001, 10.0, 10.001},
            {0.5, 0.5, 2.5, 2.5, 0.1, 0.25, 1.0, 1.0, 1.0});
  return c;
}

struct Count {
  int steps = 0, iterations = 0, gradients = 0, factorizations = 0, solves = 0, cuts = 0;
};

void print(double scale, const casting::SlabRun<3>& run, const results::StepReport& last,
           const Count& count, double hold_seconds, double held_heat) {
  const mechanics::CostSplit& cost = run.mechanics_cost();
  const double n = count.steps, whole = last.solver_seconds - hold_seconds;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "%4.2f %7lld nodes %7lld cells | step %8.3f s: analysis %.3f stiffness %.3f forces %.3f "
      "preconditioner %.3f solution %.3f contact %.3f heat %.3f | newton %.1f cg %.1f factors %.1f "
      "solves %.1f cuts %d steps %d | hold %.2f s | peak %.0f MB | corner %.6f mm\n",
      scale, static_cast<long long>(last.nodes), static_cast<long long>(last.elements), whole / n,
      cost.analysis / n, cost.stiffness / n, cost.forces / n, cost.preconditioner / n,
      cost.solution / n, cost.contact / n, (run.heat_seconds() - held_heat) / n,
      count.iterations / n, count.gradients / n, count.factorizations / n, count.solves / n,
      count.cuts, count.steps, hold_seconds, double(usage.ru_maxrss) / 1024.0,
      1e3 * last.monitor_displacement.at(0).back());
  std::fflush(stdout);
}

void measure(double scale, const Request& request) {
  casting::SlabRun<3> run(case_of(scale, request));
  results::StepReport last;
  Count count;
  double hold_seconds = 0.0, held_heat = 0.0;
  while (!run.finished()) {
    last = run.advance();
    if (last.iterations == 0) {
      hold_seconds = last.solver_seconds;
      held_heat = run.heat_seconds();
      continue;
    }
    ++count.steps;
    count.iterations += last.iterations;
    count.gradients += last.conjugate_gradient_iterations;
    count.factorizations += last.factorizations;
    count.solves += last.solves;
    count.cuts += last.failed_attempts;
    std::fprintf(stderr, "t %.3f newton %d cg %d factors %d contact %d seconds %.2f\n", last.time,
                 last.iterations, last.conjugate_gradient_iterations, last.factorizations,
                 last.contact_changes, last.solver_seconds - hold_seconds);
  }
  print(scale, run, last, count, hold_seconds, held_heat);
}

bool measure_apart(double scale, const Request& request) {
  const pid_t child = fork();
  if (child == 0) {
    measure(scale, request);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status == 0;
}

Request read(int count, char** values) {
  Request request;
  for (int i = 1; i < count; ++i) {
    const std::string value = values[i];
    if (value == "--factor") {
      request.by_factors = true;
    } else if (value == "--end" && i + 1 < count) {
      request.end = std::atof(values[++i]);
    } else {
      request.scales.push_back(std::atof(values[i]));
    }
  }
  if (request.scales.empty()) request.scales = {1.0, 1.3, 1.7, 2.3, 3.0, 4.36};
  return request;
}

}  // namespace

int main(int count, char** values) {
  const Request request = read(count, values);
  bool done = true;
  for (const double scale : request.scales) done = measure_apart(scale, request) && done;
  return done ? 0 : 3;
}
