#include "tests/verification/mechanics/time_loop.hpp"

namespace dccast::verification {

namespace {

// Data of test T3.
constexpr double side = 0.5, young = 1e9, poisson = 0.35, theta_0 = 1.953125e-39, exponent = 6.0;
constexpr double traction_rate = 1e8;  // [Pa/s]
constexpr double end_time = 0.5;
constexpr int paper_cells = 20;

double stretch(double t) {
  return traction_rate * (1.0 + poisson) / young * t + 2.0 / 3.0 * 1e40 * theta_0 * std::pow(t, 6);
}

template <class Element>
void load(FixedBody<Element>& body, double t, bool contact) {
  const double h = stretch(t), p = traction_rate * t;
  body.clear_forces();
  body.add_traction(mesh::PatchKind::side, [p](double, double) { return Vector2{p, 0.0}; });
  body.add_traction(mesh::PatchKind::top, [p](double, double) { return Vector2{0.0, -p}; });
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    const double x = body.mesh.point(n)[0], y = body.mesh.point(n)[1];
    if (x == 0.0 || (!contact && y == 0.0)) {
      body.fix(n, 0, h * x);
      body.fix(n, 1, -h * y);
    }
  }
}

template <class Element>
Result run_square(const TestRun& run, bool contact) {
  const int cells = run.cells > 0 ? run.cells : paper_cells;
  FixedBody<Element> body(uniform_rectangle(side, side, cells, cells, run.element));
  body.set_material(young, poisson, theta_0, exponent);
  // The corner on the symmetry axis is held by the given displacement; it is no contact unknown.
  if (contact) {
    body.set_contact();
    body.problem.contact.erase(body.problem.contact.begin());
    body.problem.contact_area.erase(body.problem.contact_area.begin());
    body.set_closed_contact();
  }
  const double end = run.end.value_or(end_time);
  Result result = step_through(body, run, end, [&](double t) {
    load(body, t, contact);
    body.problem.weight = traction_rate * t * side;
  });
  const double h = stretch(end), p = traction_rate * end;
  add_errors(
      result, body,
      [h](double x, double y) {
        return Vector2{h * x, -h * y};
      },
      [p](double, double) {
        return PlaneStress{{p, -p, 0.0, 0.0}};
      });
  return result;
}

}  // namespace

Result run_t3(const TestRun& run) {
  return with_element(run.element,
                      [&]<class Element>() { return run_square<Element>(run, false); });
}

Result run_t4(const TestRun& run) {
  return with_element(run.element, [&]<class Element>() { return run_square<Element>(run, true); });
}

}  // namespace dccast::verification
