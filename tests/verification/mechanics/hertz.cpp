#include <cmath>

#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/step_constraints.hpp"
#include "tests/verification/mechanics/exact_checks.hpp"
#include "tests/verification/mechanics/hertz_solution.hpp"
#include "tests/verification/mechanics/time_loop.hpp"

namespace dccast::verification {

namespace {

constexpr double young = 1e9, poisson = 0.35;
constexpr double radius = 1.0;     // of the cylinder [m]
constexpr double full_load = 1e6;  // [N/m]; half width of contact 33.4 mm
constexpr int usual_cells = 64;
// Half of the cells of a side are equal and lie over the contact, the others grow towards a body
// fifteen half widths wide and deep.
constexpr double fine_part = 0.07;  // [m], twice the half width
constexpr double growth = 6.0;

double graded(double share) {
  if (share <= 0.5) return 2.0 * fine_part * share;
  return fine_part * (1.0 + 2.0 / growth * std::expm1(growth * (share - 0.5)));
}

mesh::Mesh2D graded_square(int cells, mesh::ElementKind kind) {
  mesh::Mesh2D mesh = uniform_rectangle(1.0, 1.0, cells, cells, kind);
  for (double& x : mesh.node) x = graded(x);
  return mesh;
}

HertzContact exact_contact(double force) {
  return {force, radius, young, poisson};
}

/// Right half of a block over a cylinder, pressed by what the half-plane's other part does to it.
template <class Element>
class PressedBlock {
public:
  explicit PressedBlock(const TestRun& run)
      : body_(graded_square(run.cells > 0 ? run.cells : usual_cells, run.element)), run_(run) {
    body_.set_material(young, poisson, 0.0, 2.0);
    body_.set_contact();
    for (int unknown : body_.problem.contact) {
      const double x = body_.mesh.point(unknown / 2)[0];
      body_.problem.initial_gap.push_back(0.5 * x * x / radius);
    }
    for (int n = 0; n < body_.mesh.nodes(); ++n) {
      if (body_.mesh.point(n)[0] == 0.0) body_.fix(n, 0, 0.0);
    }
    run_.dt = 1.0;
  }

  /// @param around  stresses of the half-plane on the block's other sides, of a force on its whole
  Result press(double force, const PressedHalfPlane& around) {
    return step_through(body_, run_, 1.0, [&](double) {
      body_.clear_forces();
      for (const auto& [patch, normal] : {std::pair{mesh::PatchKind::side, Vector2{1, 0}},
                                          std::pair{mesh::PatchKind::top, Vector2{0, 1}}}) {
        body_.add_traction(
            patch, [&, n = normal](double x, double y) { return around.traction(x, y, n); });
      }
      body_.problem.weight = 0.5 * force;
    });
  }
  /// By a point force: tractions that know the load and nothing of the contact.
  Result press(double force) { return press(force, PointForce(force, poisson)); }

  /// Pressure at every contact unknown [Pa], from the balance of forces.
  std::vector<double> pressure() const {
    std::vector<double> p = reaction();
    for (std::size_t i = 0; i < p.size(); ++i) p[i] /= area(i);
    return p;
  }

  /// Raises the figures by what is wrong now.
  void add_errors_to(Figures& figures, double force) const {
    const auto raise = [&figures](const char* key, double error) {
      figures.more[key] = std::max(figures.more[key], error);
    };
    const HertzContact exact = exact_contact(force);
    const std::vector<double> p = pressure(), r = reaction();
    std::vector<double> gap;
    RelativeNorm norm;
    double total = 0.0, edge = 0.0, cell = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      gap.push_back(body_.problem.normal_gap(i, body_.displacement()));
      norm.add(area(i), p[i], exact.pressure(position(i)));
      total += r[i];
      if (body_.unknowns().contact[i] == 0 || i + 1 == p.size()) continue;
      edge = 0.5 * (position(i) + position(i + 1));
      cell = position(i + 1) - position(i);
    }
    raise("half_width_error_in_cells", std::abs(edge - exact.half_width()) / cell);
    raise("peak_pressure_error", std::abs(p.front() / exact.peak_pressure() - 1.0));
    raise("pressure_error", norm.value());
    raise("load_error", std::abs(total / (0.5 * force) - 1.0));
    const double depth = 0.5 * exact.half_width() * exact.half_width() / radius;
    raise("complementarity_error", mechanics::complementarity_error(gap, r, depth, 0.5 * force));
  }

  double area(std::size_t pair) const { return body_.problem.contact_area[pair]; }
  const FixedBody<Element>& body() const { return body_; }

private:
  double position(std::size_t pair) const {
    return body_.mesh.point(body_.problem.contact[pair] / 2)[0];
  }
  std::vector<double> reaction() const {
    mechanics::Equilibrium equilibrium(body_.problem);
    std::vector<double> residual(body_.problem.unknowns()), reaction;
    equilibrium.residual(body_.displacement(), residual, mechanics::return_map_law(body_.problem));
    for (int unknown : body_.problem.contact) reaction.push_back(residual[std::size_t(unknown)]);
    return reaction;
  }

  FixedBody<Element> body_;
  TestRun run_;
};

/// How far the contact pressure moves when the block's sides get the stresses of Hertz's contact
/// instead of a point force's.
template <class Element>
double finite_body_error(const PressedBlock<Element>& block, const TestRun& run) {
  PressedBlock<Element> other(run);
  const Result result = other.press(full_load, exact_contact(full_load));
  if (std::holds_alternative<Failed>(result)) return std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> p = block.pressure(), reference = other.pressure();
  RelativeNorm norm;
  for (std::size_t i = 0; i < p.size(); ++i) norm.add(block.area(i), p[i], reference[i]);
  return norm.value();
}

template <class Element>
Result hertz(const TestRun& run) {
  PressedBlock<Element> block(run);
  Result result = block.press(full_load);
  const HertzContact exact = exact_contact(full_load);
  add_errors(
      result, block.body(), [&](double x, double y) { return exact.displacement(x, y); },
      [&](double x, double y) { return exact.stress(x, y); });
  if (auto* figures = std::get_if<Figures>(&result)) {
    block.add_errors_to(*figures, full_load);
    figures->more["finite_body_error"] = finite_body_error(block, run);
  }
  return result;
}

template <class Element>
Result hertz_cycle(const TestRun& run) {
  PressedBlock<Element> block(run);
  Figures all;
  std::vector<double> first;
  constexpr double shares[] = {0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25};
  for (const double share : shares) {
    const Result result = block.press(share * full_load);
    if (std::holds_alternative<Failed>(result)) return result;
    const Figures& one = std::get<Figures>(result);
    all.elements = one.elements, all.nodes = one.nodes;
    all.cpu_s += one.cpu_s, all.steps += one.steps;
    all.iterations_per_step += one.iterations_per_step / std::size(shares);
    block.add_errors_to(all, share * full_load);
    if (first.empty()) first = block.body().displacement();
  }
  all.displacement = block.body().displacement();
  RelativeNorm norm;
  for (std::size_t i = 0; i < first.size(); ++i) norm.add(1.0, all.displacement[i], first[i]);
  all.more["difference_after_cycle"] = norm.value();
  all.displacement_error = all.stress_error = std::numeric_limits<double>::quiet_NaN();
  return all;
}

}  // namespace

Result run_hertz(const TestRun& run) {
  return with_element(run.element, [&]<class Element>() { return hertz<Element>(run); });
}

Result run_hertz_cycle(const TestRun& run) {
  return with_element(run.element, [&]<class Element>() { return hertz_cycle<Element>(run); });
}

}  // namespace dccast::verification
