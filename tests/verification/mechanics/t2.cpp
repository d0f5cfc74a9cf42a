#include "core/material/mechanical_properties.hpp"
#include "tests/verification/mechanics/time_loop.hpp"

namespace dccast::verification {

namespace {

// Data of test T2.
constexpr double side = 0.5, young = 1e9, poisson = 0.35, end_time = 200.0;
constexpr double liquidus = 649.0, solidus = 607.0, final_temperature = 100.0;
constexpr double lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
constexpr double mu = young / (2.0 * (1.0 + poisson));
constexpr int paper_cells = 80;

/// rho(T) of eq. (71).
double density(double temperature) {
  const double at_solidus = 2700.0 - 0.23 * solidus;
  if (temperature <= solidus) return 2700.0 - 0.23 * temperature;
  const double share = std::min(1.0, (temperature - solidus) / (liquidus - solidus));
  return at_solidus + share * (2360.0 - at_solidus);
}

/// The thermal strain integral from the liquidus, exactly.
double thermal_strain(double t) {
  const double temperature = liquidus + (final_temperature - liquidus) * t / end_time;
  return std::cbrt(2360.0 / density(temperature)) - 1.0;
}

/// Where the slab lifts off: the front of contact moves from 0.4 m to 0.2 m.
double front(double t) {
  return 0.4 - 1e-3 * t;
}

Vector2 exact_displacement(double x, double y, double t) {
  const double h = x - front(t), scale = (1.0 + poisson) * thermal_strain(t);
  return {scale * x, scale * y + (h <= 0.0 ? h * h * h * y : h * h * h)};
}

PlaneStress exact_stress(double x, double y, double t) {
  const double h = x - front(t), out_of_plane = -young * thermal_strain(t);
  if (h > 0.0) return {{0.0, 0.0, out_of_plane, 3.0 * mu * h * h}};
  const double h3 = h * h * h;
  return {
      {lambda * h3, (lambda + 2.0 * mu) * h3, out_of_plane + lambda * h3, 3.0 * mu * h * h * y}};
}

Vector2 body_force(double x, double y, double t) {
  const double h = x - front(t);
  if (h > 0.0) return {0.0, -6.0 * mu * h};
  return {-3.0 * (lambda + mu) * h * h, -6.0 * mu * h * y};
}

template <class Element>
void load(FixedBody<Element>& body, double t) {
  body.clear_forces();
  body.add_body_force([t](double x, double y) { return body_force(x, y, t); });
  body.add_traction(mesh::PatchKind::side, [t](double x, double) {
    const double h = x - front(t);
    return Vector2{0.0, 3.0 * mu * h * h};
  });
  body.add_traction(mesh::PatchKind::bottom, [t](double x, double) {
    const double h = x - front(t);
    return Vector2{h > 0.0 ? -3.0 * mu * h * h : 0.0, 0.0};
  });
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    const double x = body.mesh.point(n)[0], y = body.mesh.point(n)[1];
    if (x != 0.0 && y != side) continue;
    const Vector2 u = exact_displacement(x, y, t);
    body.fix(n, 0, u[0]);
    body.fix(n, 1, u[1]);
  }
  std::fill(body.problem.thermal.begin(), body.problem.thermal.end(), thermal_strain(t));
}

/// Material and contact of the square.
template <class Element>
void set_up(FixedBody<Element>& body) {
  body.set_material(young, poisson, 0.0, 2.0);
  body.set_contact();
  body.problem.contact.erase(body.problem.contact.begin());  // held: on the line x2 = 0
  body.problem.contact_area.erase(body.problem.contact_area.begin());
  body.set_closed_contact();
  body.problem.weight = mu * side * 1e-3;  // scale of the contact forces
}

template <class Element>
Result run_contact_square(const TestRun& run) {
  const int cells = run.cells > 0 ? run.cells : paper_cells;
  FixedBody<Element> body(uniform_rectangle(side, side, cells, cells, run.element));
  set_up(body);
  const double end = run.end.value_or(end_time);
  Result result = step_through(body, run, end, [&](double t) { load(body, t); });
  add_errors(
      result, body, [end](double x, double y) { return exact_displacement(x, y, end); },
      [end](double x, double y) { return exact_stress(x, y, end); });
  return result;
}

}  // namespace

Result run_t2(const TestRun& run) {
  return with_element(run.element,
                      [&]<class Element>() { return run_contact_square<Element>(run); });
}

DeformedSquare deform_t2(int cells) {
  FixedBody<fem::Q1Quadrilateral> body(
      uniform_rectangle(side, side, cells, cells, mesh::ElementKind::q1));
  set_up(body);
  TestRun run;
  run.dt = 10.0;
  step_through(body, run, end_time, [&](double t) { load(body, t); });

  DeformedSquare deformed{body.mesh, {}, {}};
  for (int e = 0; e < body.mesh.elements(); ++e) {
    double shift = 0.0;
    for (int i = 0; i < body.mesh.nodes_per_element; ++i) {
      const int n = body.mesh.nodes_of(e)[i];
      shift += std::hypot(body.displacement(n, 0), body.displacement(n, 1)) / 4.0;
    }
    deformed.shift.push_back(shift);

    double mises = 0.0;
    for (std::size_t p = 0; p < fem::Q1Quadrilateral::points; ++p) {
      const PlaneStress s = body.stress(e, p).deviator();
      mises += std::sqrt(1.5 * s.squared_norm()) / double(fem::Q1Quadrilateral::points);
    }
    deformed.mises.push_back(mises);
  }
  for (std::size_t i = 0; i < deformed.mesh.node.size(); ++i)
    deformed.mesh.node[i] += body.displacement()[i];
  return deformed;
}

}  // namespace dccast::verification
