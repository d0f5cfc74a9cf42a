#include <Eigen/Eigenvalues>
#include <cmath>

#include "tests/verification/mechanics/exact_checks.hpp"
#include "tests/verification/mechanics/time_loop.hpp"

namespace dccast::verification {

namespace {

constexpr double young = 1e9, almost_one_half = 0.4999;
constexpr int usual_layers = 4, columns = 6;
constexpr double thickness = 0.02;  // of the plate [m]

/// Deflection of a plate in plane strain, bent by end moments, over that of beam theory.
/// @param cell  length of a cell over the thickness of the plate
template <class Element>
Result bent_plate(TestRun run, double poisson, double cell, int layers) {
  constexpr double slope = 1e8;  // of the end traction across the plate [Pa/m]
  const double length = cell * thickness * columns;
  FixedBody<Element> body(uniform_rectangle(length, thickness, columns, layers, run.element));
  body.set_material(young, poisson, 0.0, 2.0);
  for (int n = 0; n < body.mesh.nodes(); n += columns + 1) body.fix(n, 0, 0.0);
  body.fix(0, 1, 0.0);
  body.add_traction(mesh::PatchKind::side, [](double, double y) {
    return Vector2{slope * (y - 0.5 * thickness), 0.0};
  });
  run.dt = 1.0;
  run.options.contact = false;
  Result result = step_through(body, run, 1.0, [](double) {});
  if (auto* figures = std::get_if<Figures>(&result)) {
    const double exact = -slope * length * length * (1.0 - poisson * poisson) / (2.0 * young);
    figures->displacement_error = std::abs(body.displacement()[2 * columns + 1] / exact - 1.0);
  }
  return result;
}

template <class Element>
Result plate(const TestRun& run) {
  const int layers = run.cells > 0 ? run.cells : usual_layers;
  Figures all;
  for (const double cell : {1.0, 2.75, 5.5, 10.0}) {
    const Result thick = bent_plate<Element>(run, 0.3, cell, layers);
    const Result single = bent_plate<Element>(run, almost_one_half, cell, 1);
    for (const Result* one : {&thick, &single}) {
      if (std::holds_alternative<Failed>(*one)) return *one;
    }
    const Figures &of_layers = std::get<Figures>(thick), &of_one = std::get<Figures>(single);
    all.displacement_error = std::max(all.displacement_error, of_layers.displacement_error);
    double& worst = all.more["displacement_error_one_layer_nearly_incompressible"];
    worst = std::max(worst, of_one.displacement_error);
    all.cpu_s += of_layers.cpu_s + of_one.cpu_s;
    all.elements = of_layers.elements, all.nodes = of_layers.nodes, all.steps = of_layers.steps;
    all.iterations_per_step = of_layers.iterations_per_step;
  }
  return all;
}

/// Eigenvalues of the stiffness of one skewed cell, smallest first.
template <class Element>
Eigen::VectorXd spectrum_of_cell(double poisson, mesh::ElementKind kind) {
  mesh::Mesh2D mesh = uniform_rectangle(1.0, 1.0, 1, 1, kind);
  constexpr double moved[] = {0.1, 0.0, 0.1, 0.3, 0.3, 0.1, 0.2, 0.4};
  for (std::size_t i = 0; i < mesh.node.size(); ++i) mesh.node[i] += moved[i];
  FixedBody<Element> body(std::move(mesh));
  body.set_material(young, poisson, 0.0, 2.0);
  body.problem.dt = 1.0;
  const std::size_t unknowns = body.problem.unknowns();
  std::vector<double> u(unknowns, 0.0), product(unknowns), values(body.pattern.entries());
  mechanics::Equilibrium equilibrium(body.problem);
  equilibrium.residual(u, product, mechanics::return_map_law(body.problem));
  equilibrium.tangent(values);
  Eigen::MatrixXd k(unknowns, unknowns);
  for (std::size_t i = 0; i < unknowns; ++i) {
    u[i] = 1.0;
    linalg::multiply(body.pattern, values, u, product);
    u[i] = 0.0;
    k.col(static_cast<int>(i)) = Eigen::Map<const Eigen::VectorXd>(product.data(), k.rows());
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
}

template <class Element>
Result modes(const TestRun& run) {
  Figures figures;
  figures.elements = 1, figures.nodes = 4, figures.steps = 1;
  for (const double poisson : {0.3, almost_one_half}) {
    const Eigen::VectorXd values = spectrum_of_cell<Element>(poisson, run.element);
    const auto free = (values.array().abs() < 1e-12 * values.maxCoeff()).count();
    double& most = figures.more["modes_without_energy"];
    most = std::max(most, static_cast<double>(free));
    if (poisson == 0.3) figures.more["softest_over_stiffest"] = values(free) / values.maxCoeff();
  }
  return figures;
}

}  // namespace

Result run_plate(const TestRun& run) {
  return with_element(run.element, [&]<class Element>() { return plate<Element>(run); });
}

Result run_modes(const TestRun& run) {
  return with_element(run.element, [&]<class Element>() { return modes<Element>(run); });
}

}  // namespace dccast::verification
