#include "tests/verification/mechanics/exact_checks.hpp"

#include <cmath>

#include "tests/verification/mechanics/time_loop.hpp"

namespace dccast::verification {

namespace {

constexpr double side = 0.5, young = 1e9, poisson = 0.35;
constexpr double mu = young / (2.0 * (1.0 + poisson));
constexpr double lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
constexpr double kappa = 1.953125e-39, exponent = 6.0;  // of the paper's T3
constexpr int usual_cells = 20;

int cells_of(const TestRun& run) {
  return run.cells > 0 ? run.cells : usual_cells;
}

bool on_boundary(const double* x, double width, double height) {
  return x[0] == 0.0 || x[1] == 0.0 || x[0] == width || x[1] == height;
}

/// Moves inner nodes by up to a fifth of a cell, the same way in every run.
void distort(mesh::Mesh2D& mesh, double cell) {
  for (int n = 0; n < mesh.nodes(); ++n) {
    double* x = mesh.node.data() + 2 * std::size_t(n);
    if (on_boundary(x, side, side)) continue;
    x[0] += 0.2 * cell * std::sin(7.0 * n);
    x[1] += 0.2 * cell * std::cos(11.0 * n);
  }
}

void without_creep(auto& body) {
  body.set_material(young, poisson, 0.0, 2.0);
}

template <class Element>
Result patch(const TestRun& run) {
  // u = (a x + (b - w) y, (b + w) x + d y): every strain, and a rotation w.
  constexpr double a = 1e-3, b = 4e-4, d = -3e-4, w = 2e-2;
  auto mesh = uniform_rectangle(side, side, cells_of(run), cells_of(run), run.element);
  distort(mesh, side / cells_of(run));
  FixedBody<Element> body(std::move(mesh));
  without_creep(body);
  const auto exact = [](double x, double y) {
    return Vector2{a * x + (b - w) * y, (b + w) * x + d * y};
  };
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    const double* x = body.mesh.point(n);
    if (!on_boundary(x, side, side)) continue;
    const Vector2 u = exact(x[0], x[1]);
    body.fix(n, 0, u[0]);
    body.fix(n, 1, u[1]);
  }
  TestRun once = run;
  once.dt = 1.0;
  once.options.contact = false;
  once.options.tolerance = 1e-12;
  Result result = step_through(body, once, 1.0, [](double) {});
  add_errors(result, body, exact, [](double, double) {
    const double p = lambda * (a + d);
    return PlaneStress{{p + 2.0 * mu * a, p + 2.0 * mu * d, p, 2.0 * mu * b}};
  });
  return result;
}

template <class Element>
void hold_symmetry(FixedBody<Element>& body) {
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    if (body.mesh.point(n)[0] == 0.0) body.fix(n, 0, 0.0);
    if (body.mesh.point(n)[1] == 0.0) body.fix(n, 1, 0.0);
  }
}

template <class Element>
Result creep(const TestRun& run) {
  constexpr double traction = 3e7, end = 0.5;
  FixedBody<Element> body(uniform_rectangle(side, side, cells_of(run), cells_of(run), run.element));
  body.set_material(young, poisson, kappa, exponent);
  hold_symmetry(body);
  body.add_traction(mesh::PatchKind::side, [](double, double) { return Vector2{traction, 0.0}; });
  body.add_traction(mesh::PatchKind::top, [](double, double) { return Vector2{0.0, -traction}; });
  TestRun loaded = run;
  loaded.options.contact = false;
  Result result = step_through(body, loaded, end, [](double) {});
  const double norm = std::sqrt(2.0) * traction;
  const double strain =
      traction / (2.0 * mu) + end * kappa * std::pow(norm, exponent - 2.0) * traction;
  add_errors(
      result, body,
      [strain](double x, double y) {
        return Vector2{strain * x, -strain * y};
      },
      [](double, double) {
        return PlaneStress{{traction, -traction, 0.0, 0.0}};
      });
  return result;
}

template <class Element>
Result relaxation(const TestRun& run) {
  constexpr double start = 4e7, end = 0.5;  // deviator held at first [Pa], and for how long [s]
  constexpr double strain = start / (2.0 * mu);
  FixedBody<Element> body(uniform_rectangle(side, side, cells_of(run), cells_of(run), run.element));
  body.set_material(young, poisson, kappa, exponent);
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    const double* x = body.mesh.point(n);
    if (!on_boundary(x, side, side)) continue;
    body.fix(n, 0, strain * x[0]);
    body.fix(n, 1, -strain * x[1]);
  }
  TestRun held = run;
  held.options.contact = false;
  Result result = step_through(body, held, end, [](double) {});
  const double norm = std::sqrt(2.0) * start, order = exponent - 2.0;
  const double relaxed =
      std::pow(std::pow(norm, -order) + order * 2.0 * mu * kappa * end, -1.0 / order);
  const double p = relaxed / std::sqrt(2.0);
  add_errors(
      result, body,
      [](double x, double y) {
        return Vector2{strain * x, -strain * y};
      },
      [p](double, double) {
        return PlaneStress{{p, -p, 0.0, 0.0}};
      });
  if (auto* figures = std::get_if<Figures>(&result)) figures->more["relaxed_to"] = p / start;
  return result;
}

template <class Element>
Result bowed_strip(const TestRun& run) {
  constexpr double length = 0.5, thickness = 0.05, slope = 0.1;  // slope k of thermal strain [1/m]
  const int rows = cells_of(run) / 2;
  FixedBody<Element> body(uniform_rectangle(length, thickness, 10 * rows, rows, run.element));
  without_creep(body);
  const auto exact = [](double x, double y) {
    return Vector2{(1.0 + poisson) * slope * x * y,
                   0.5 * (1.0 + poisson) * slope * (y * y - x * x)};
  };
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    const double* x = body.mesh.point(n);
    if (x[0] == 0.0) body.fix(n, 0, 0.0);
    if (x[0] == 0.0 && x[1] == 0.0) body.fix(n, 1, 0.0);
  }
  for (int e = 0; e < body.mesh.elements(); ++e) {
    double y = 0.0;
    for (std::size_t i = 0; i < Element::nodes; ++i) {
      y += body.mesh.point(body.mesh.nodes_of(e)[i])[1] / Element::nodes;
    }
    body.problem.thermal[std::size_t(e)] = slope * y;
  }
  TestRun once = run;
  once.dt = 1.0;
  once.options.contact = false;
  Result result = step_through(body, once, 1.0, [](double) {});
  add_errors(result, body, exact, [](double, double y) {
    return PlaneStress{{0.0, 0.0, -young * slope * y, 0.0}};
  });
  return result;
}

}  // namespace

Result run_patch(const TestRun& run) {
  return with_element(run.element, [&]<class Element>() { return patch<Element>(run); });
}

Result run_creep(const TestRun& run) {
  return with_element(run.element, [&]<class Element>() { return creep<Element>(run); });
}

Result run_relaxation(const TestRun& run) {
  return with_element(run.element, [&]<class Element>() { return relaxation<Element>(run); });
}

Result run_bowed_strip(const TestRun& run) {
  return with_element(run.element, [&]<class Element>() { return bowed_strip<Element>(run); });
}

}  // namespace dccast::verification
