#include <cmath>

#include "tests/verification/mechanics/exact_checks.hpp"
#include "tests/verification/mechanics/time_loop.hpp"

namespace dccast::verification {

namespace {

// A tube under inner pressure, its ends held: plane strain along the axis.
constexpr double inner = 0.1, outer = 0.3;  // [m]
constexpr double tube_pressure = 5e7;       // [Pa]
constexpr double young = 1e10, poisson = 0.3;
constexpr double kappa = 1e-41, exponent = 6.0;  // creep rate 1e-3 /s at the inner wall
constexpr int usual_cells = 40;

int cells_of(const TestRun& run) {
  return run.cells > 0 ? run.cells : usual_cells;
}

template <class Run>
Result with_axisymmetric_element(mesh::ElementKind kind, Run&& run) {
  if (kind == mesh::ElementKind::p1) return run.template operator()<fem::AxisymmetricP1>();
  if (kind == mesh::ElementKind::q1) return run.template operator()<fem::AxisymmetricQ1>();
  return run.template operator()<fem::AxisymmetricBending>();
}

template <class Element>
Result patch(const TestRun& run) {
  constexpr double across = 1e-3, along = -4e-4, side = 0.5;
  const int cells = cells_of(run);
  auto mesh = uniform_rectangle(side, side, cells, cells, run.element);
  std::vector<char> held(std::size_t(mesh.nodes()), 0);
  for (const auto& patch : mesh.patches) {
    for (const auto& facet : patch.facets)
      held[std::size_t(facet.node[0])] = held[std::size_t(facet.node[1])] = 1;
  }
  for (int n = 0; n < mesh.nodes(); ++n) {
    if (held[std::size_t(n)] != 0) continue;
    mesh.node[2 * std::size_t(n)] += 0.2 * side / cells * std::sin(7.0 * n);
    mesh.node[2 * std::size_t(n) + 1] += 0.2 * side / cells * std::cos(11.0 * n);
  }
  FixedBody<Element> body(std::move(mesh));
  body.set_material(young, poisson, 0.0, 2.0);
  const auto exact = [](double r, double z) { return Vector2{across * r, along * z}; };
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    if (held[std::size_t(n)] == 0) continue;
    const Vector2 u = exact(body.mesh.point(n)[0], body.mesh.point(n)[1]);
    for (int d = 0; d < 2; ++d) body.fix(n, d, u[std::size_t(d)]);
  }
  TestRun once = run;
  once.dt = 1.0;
  once.options.contact = false;
  once.options.tolerance = 1e-12;
  Result result = step_through(body, once, 1.0, [](double) {});
  add_errors(result, body, exact, [](double, double) {
    constexpr double mu = young / (2.0 * (1.0 + poisson));
    constexpr double p =
        young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)) * (2 * across + along);
    return PlaneStress{{p + 2 * mu * across, p + 2 * mu * along, p + 2 * mu * across, 0.0}};
  });
  return result;
}

/// Section of the tube, as high as a quarter of its wall is thick.
template <class Element>
class Tube : public FixedBody<Element> {
public:
  explicit Tube(const TestRun& run) : FixedBody<Element>(section(cells_of(run), run.element)) {
    const double top = this->mesh.node.back();
    for (int n = 0; n < this->mesh.nodes(); ++n) {
      const double z = this->mesh.point(n)[1];
      if (z == 0.0 || z == top) this->fix(n, 1, 0.0);
    }
    this->add_traction(mesh::PatchKind::symmetry, [](double, double) {
      return Vector2{tube_pressure, 0.0};
    });
  }

private:
  static mesh::Mesh2D section(int cells, mesh::ElementKind kind) {
    const double wall = outer - inner;
    mesh::Mesh2D mesh = uniform_rectangle(wall, 0.25 * wall, cells, std::max(1, cells / 4), kind);
    for (std::size_t i = 0; i < mesh.node.size(); i += 2) mesh.node[i] += inner;
    return mesh;
  }
};

template <class Element>
Result elastic_tube(const TestRun& run, double nu) {
  Tube<Element> tube(run);
  tube.set_material(young, nu, 0.0, 2.0);
  TestRun once = run;
  once.dt = 1.0;
  once.options.contact = false;
  Result result = step_through(tube, once, 1.0, [](double) {});
  constexpr double mean = tube_pressure * inner * inner / (outer * outer - inner * inner);
  add_errors(
      result, tube,
      [nu](double r, double) {
        return Vector2{(1.0 + nu) / young * mean * ((1.0 - 2.0 * nu) * r + outer * outer / r), 0.0};
      },
      [nu](double r, double) {
        const double difference = mean * outer * outer / (r * r);
        return PlaneStress{{mean - difference, 2.0 * nu * mean, mean + difference, 0.0}};
      });
  return result;
}

template <class Element>
Result tube(const TestRun& run) {
  TestRun half = run;
  half.cells = cells_of(run) / 2;
  Result result = elastic_tube<Element>(run, poisson);
  const Result coarse = elastic_tube<Element>(half, poisson);
  const Result rubber = elastic_tube<Element>(run, 0.4999);
  for (const Result* one : std::initializer_list<const Result*>{&result, &coarse, &rubber}) {
    if (std::holds_alternative<Failed>(*one)) return *one;
  }
  Figures& figures = std::get<Figures>(result);
  const Figures &before = std::get<Figures>(coarse), &nearly = std::get<Figures>(rubber);
  figures.more["order_displacement"] =
      std::log2(before.displacement_error / figures.displacement_error);
  figures.more["order_stress"] = std::log2(before.stress_error / figures.stress_error);
  figures.more["displacement_error_nearly_incompressible"] = nearly.displacement_error;
  figures.more["stress_error_nearly_incompressible"] = nearly.stress_error;
  return result;
}

template <class Element>
Result creeping_tube(const TestRun& run) {
  constexpr double end = 200.0, order = exponent - 1.0;  // of Norton's law
  Tube<Element> tube(run);
  tube.set_material(young, poisson, kappa, exponent);
  TestRun loaded = run;
  loaded.options.contact = false;
  std::vector<double> before;
  Result result = step_through(tube, loaded, end, [&](double) { before = tube.displacement(); });
  const double wall = std::pow(outer / inner, 2.0 / order) - 1.0;
  const auto difference = [=](double r) {  // half of hoop less radial stress
    return tube_pressure / order * std::pow(outer / r, 2.0 / order) / wall;
  };
  add_errors(
      result, tube,
      [](double, double) {
        return Vector2{0.0, 0.0};
      },
      [=](double r, double) {
        const double radial = -tube_pressure * (std::pow(outer / r, 2.0 / order) - 1.0) / wall;
        const double half = difference(r);
        return PlaneStress{{radial, radial + half, radial + 2.0 * half, 0.0}};
      });
  if (auto* figures = std::get_if<Figures>(&result)) {
    figures->displacement_error = std::numeric_limits<double>::quiet_NaN();
    const double exact = kappa * std::pow(std::sqrt(2.0) * difference(inner), exponent - 2.0) *
                         difference(inner) * inner;
    const double rate = (tube.displacement()[0] - before[0]) / run.dt;
    figures->more["rate_error"] = std::abs(rate / exact - 1.0);
  }
  return result;
}

}  // namespace

Result run_axisymmetric_patch(const TestRun& run) {
  return with_axisymmetric_element(run.element,
                                   [&]<class Element>() { return patch<Element>(run); });
}

Result run_tube(const TestRun& run) {
  return with_axisymmetric_element(run.element,
                                   [&]<class Element>() { return tube<Element>(run); });
}

Result run_tube_creep(const TestRun& run) {
  return with_axisymmetric_element(run.element,
                                   [&]<class Element>() { return creeping_tube<Element>(run); });
}

}  // namespace dccast::verification
