#include "tests/verification/mechanics/t1.hpp"
#include "tests/support/usual_options.hpp"

#include <cmath>
#include <stdexcept>

#include "tests/verification/mechanics/fixed_body.hpp"

namespace dccast::verification {

namespace {

// Data of test T1. The pressure is rho g (x3 - h): as printed, without rho, it is no solution.
constexpr double half_width = 0.25, height = 0.8, side_of_solid = 0.6, side_free = 0.5;
constexpr double weight = 2500.0 * 9.81;  // rho g [N/m3]
constexpr double lambda = 1.5e6, mu = 3.5e5, liquid_lambda = 1e4, liquid_mu = 10.0;
constexpr double c = weight / (4.0 * (lambda + mu));
constexpr double away_from_front = 0.1;
constexpr double snug = 1e-9;  // [m] two places closer than this are one

double front(double x) {
  return 0.4 + 0.8 * std::abs(x);
}

double distance_to_front(double x, double y) {
  // Foot on the straight branch of the same side, not beyond its ends.
  const double t = std::clamp((std::abs(x) + 0.8 * (y - 0.4)) / (1.0 + 0.64), 0.0, half_width);
  return std::hypot(std::abs(x) - t, y - front(t));
}

Vector2 exact_displacement(double x, double y) {
  const double depth = y - height;
  return {c * 2.0 * depth * x, c * (depth * depth - x * x - 0.85 * 0.85)};
}

/// Hydrostatic in the plane only; out of it plane strain gives lambda / (lambda + mu) of that.
PlaneStress exact_stress(double, double y) {
  const double p = weight * (y - height);
  return {{p, p, lambda / (lambda + mu) * p, 0.0}};
}

class MappedMesh {
public:
  MappedMesh(const T1Run& run) : run_(run) {
    if (run.columns % 2 != 0 || run.rows % 6 != 0 || run.columns < 2 || run.rows < 6) {
      throw std::invalid_argument("T1: columns must be even and rows a multiple of 6");
    }
    liquid_rows_ = run.liquid ? run.liquid_rows : 0;
    place_nodes();
    mesh_.nodes_per_element = run.element == mesh::ElementKind::p1 ? 3 : 4;
    for (int j = 0; j < run.rows + liquid_rows_; ++j) {
      for (int i = 0; i < run.columns; ++i) add_cell(i, j);
    }
    add_facets();
  }
  mesh::Mesh2D take() { return std::move(mesh_); }

private:
  int node(int i, int j) const { return j * (run_.columns + 1) + i; }

  void place_nodes() {
    for (int j = 0; j <= run_.rows + liquid_rows_; ++j) {
      for (int i = 0; i <= run_.columns; ++i) {
        const double x = half_width * (2.0 * i / run_.columns - 1.0), at_front = front(x);
        const double y = j <= run_.rows
                             ? at_front * j / run_.rows
                             : at_front + (height - at_front) * (j - run_.rows) / liquid_rows_;
        mesh_.node.insert(mesh_.node.end(), {x, y});
      }
    }
  }

  bool rising(int i) const {
    const bool left = 2 * i < run_.columns;
    switch (run_.diagonals) {
      case Diagonals::rising:
        return true;
      case Diagonals::falling:
        return false;
      case Diagonals::mirrored:
        return left;
      case Diagonals::mirrored_back:
        return !left;
    }
    return true;
  }

  void add_cell(int i, int j) {
    const int a = node(i, j), b = node(i + 1, j), d = node(i + 1, j + 1), e = node(i, j + 1);
    auto& to = mesh_.element_node;
    if (run_.element != mesh::ElementKind::p1) {
      to.insert(to.end(), {a, b, d, e});
    } else if (rising(i)) {
      to.insert(to.end(), {a, b, d, a, d, e});
    } else {
      to.insert(to.end(), {a, b, e, b, d, e});
    }
  }

  /// The sides where the pressure is given, and the front where there is no liquid.
  void add_facets() {
    const int loaded = run_.rows * 5 / 6;
    for (int j = 0; j < loaded; ++j) {
      mesh_.facets(mesh::PatchKind::side)
          .push_back({{node(run_.columns, j), node(run_.columns, j + 1)}});
      mesh_.facets(mesh::PatchKind::side).push_back({{node(0, j + 1), node(0, j)}});
    }
    if (liquid_rows_ > 0) return;
    for (int i = run_.columns; i > 0; --i) {
      mesh_.facets(mesh::PatchKind::top).push_back({{node(i, run_.rows), node(i - 1, run_.rows)}});
    }
  }

  const T1Run& run_;
  int liquid_rows_ = 0;
  mesh::Mesh2D mesh_;
};

template <class Element>
void set_materials(FixedBody<Element>& body, const T1Run& run, int solid_elements) {
  auto& p = body.problem;
  for (std::size_t e = 0; e < p.bulk.size(); ++e) {
    double first = lambda, second = mu;
    if (static_cast<int>(e) >= solid_elements) {
      first = std::pow(run.liquid->epsilon, run.liquid->beta) * liquid_lambda;
      second = std::pow(run.liquid->epsilon, run.liquid->delta) * liquid_mu;
    }
    p.bulk[e] = first + 2.0 / 3.0 * second;
    p.shear[e] = second;
  }
}

template <class Element>
void load(FixedBody<Element>& body) {
  body.add_body_force([](double, double) { return Vector2{0.0, -weight}; });
  body.add_traction(mesh::PatchKind::side, [](double x, double y) {
    return Vector2{weight * (y - height) * (x > 0.0 ? 1.0 : -1.0), 0.0};
  });
  body.add_traction(mesh::PatchKind::top, [](double x, double y) {
    const double p = weight * (y - height) / std::sqrt(41.0);
    return Vector2{x > 0.0 ? -4.0 * p : 4.0 * p, 5.0 * p};
  });
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    const double x = body.mesh.point(n)[0], y = body.mesh.point(n)[1];
    const Vector2 u = exact_displacement(x, y);
    if (y == 0.0) body.fix(n, 1, u[1]);
    // The liquid's sides, not stated in the paper, are held as the solid's above 0.5 m are.
    if (y == 0.0 || (std::abs(x) > half_width - snug && y > side_free - snug)) body.fix(n, 0, u[0]);
  }
}

/// Errors over one part of the solid, gathered element by element.
class PartNorms {
public:
  void add_point(double weight_, const Vector2& u, const Vector2& exact_u, const PlaneStress& s,
                 const PlaneStress& exact_s) {
    for (std::size_t d = 0; d < 2; ++d) u_.add(weight_, u[d], exact_u[d]);
    s_.add(weight_, s, exact_s);
  }
  void add_node(const Vector2& u, const Vector2& exact) {
    u_error_ = std::max(u_error_, std::hypot(u[0] - exact[0], u[1] - exact[1]));
    u_scale_ = std::max(u_scale_, std::hypot(exact[0], exact[1]));
  }
  void add_centroid(const PlaneStress& s, const PlaneStress& exact) {
    PlaneStress difference = s;
    s_error_ = std::max(s_error_, difference.add(-1.0, exact).norm());
    s_scale_ = std::max(s_scale_, exact.norm());
  }
  PartErrors errors() const {
    return {u_.value(), u_error_ / u_scale_, s_.value(), s_error_ / s_scale_};
  }

private:
  RelativeNorm u_, s_;
  double u_error_ = 0.0, u_scale_ = 0.0, s_error_ = 0.0, s_scale_ = 0.0;
};

Vector2 displacement_of(std::span<const double> u, int n) {
  return {u[2 * std::size_t(n)], u[2 * std::size_t(n) + 1]};
}

template <class Element>
void measure(const FixedBody<Element>& body, const std::vector<PlaneStress>& stress,
             T1Result& result) {
  PartNorms whole, away;
  const auto& u = body.displacement();
  for (int e = 0; e < result.solid_elements; ++e) {
    const int* node = body.mesh.nodes_of(e);
    const PlaneStress& s = stress[std::size_t(e)];
    Vector2 centroid{};
    for (const IntegrationPoint& point : integration_points(body.mesh, e)) {
      Vector2 value{};
      for (std::size_t i = 0; i < Element::nodes; ++i) {
        const Vector2 at = displacement_of(u, node[i]);
        for (std::size_t d = 0; d < 2; ++d) value[d] += point.shape[i] * at[d];
      }
      const Vector2 exact_u = exact_displacement(point.x, point.y);
      const PlaneStress exact_s = exact_stress(point.x, point.y);
      whole.add_point(point.weight, value, exact_u, s, exact_s);
      if (distance_to_front(point.x, point.y) >= away_from_front) {
        away.add_point(point.weight, value, exact_u, s, exact_s);
      }
      centroid[0] += point.weight * point.x / body.forms.geometry().cell(e).volume;
      centroid[1] += point.weight * point.y / body.forms.geometry().cell(e).volume;
    }
    const PlaneStress exact = exact_stress(centroid[0], centroid[1]);
    whole.add_centroid(s, exact);
    if (distance_to_front(centroid[0], centroid[1]) >= away_from_front) away.add_centroid(s, exact);
    for (std::size_t i = 0; i < Element::nodes; ++i) {
      const double* x = body.mesh.point(node[i]);
      const Vector2 at = displacement_of(u, node[i]), exact_u = exact_displacement(x[0], x[1]);
      whole.add_node(at, exact_u);
      if (distance_to_front(x[0], x[1]) >= away_from_front) away.add_node(at, exact_u);
    }
  }
  result.whole = whole.errors();
  result.away = away.errors();
}

/// Mean over the points of every element.
template <class Element>
std::vector<PlaneStress> element_stresses(const FixedBody<Element>& body) {
  const auto at_points = body.stresses();
  std::vector<PlaneStress> mean(std::size_t(body.mesh.elements()));
  for (std::size_t i = 0; i < at_points.size(); ++i) {
    const auto& cell = body.forms.geometry().cell(static_cast<int>(i / Element::points));
    mean[i / Element::points].add(cell.point[i % Element::points].weight / cell.volume,
                                  at_points[i]);
  }
  return mean;
}

/// Pressure of the liquid's lowest row against rho g depth, relative to the largest on the front.
template <class Element>
double pressure_error(const FixedBody<Element>& body, const std::vector<PlaneStress>& stress,
                      const T1Run& run, int solid_elements) {
  if (!run.liquid) return 0.0;
  const int per_row = solid_elements / run.rows;
  double worst = 0.0;
  for (int e = solid_elements; e < solid_elements + per_row; ++e) {
    double y = 0.0;
    for (std::size_t i = 0; i < Element::nodes; ++i) {
      y += body.mesh.point(body.mesh.nodes_of(e)[i])[1] / Element::nodes;
    }
    const double mean = stress[std::size_t(e)].trace() / 3.0;
    worst = std::max(worst, std::abs(mean - weight * (y - height)));
  }
  return worst / (weight * (height - 0.4));
}

template <class Element>
T1Result solve(const T1Run& run) {
  const double start = cpu_seconds();
  T1Result result;
  FixedBody<Element> body(MappedMesh(run).take());
  const int per_cell = run.element == mesh::ElementKind::p1 ? 2 : 1;
  result.solid_elements = run.columns * run.rows * per_cell;
  set_materials(body, run, result.solid_elements);
  load(body);
  mechanics::Options options = testing::usual_options(1e-8);
  options.contact = false;
  body.problem.weight = weight * 2.0 * half_width * height;
  const auto outcome = body.step(options, 1.0);
  if (!outcome.converged) throw std::runtime_error("T1: the linear problem was not solved");
  result.cpu_s = cpu_seconds() - start;
  result.nodes = body.mesh.nodes();
  const auto stress = element_stresses(body);
  for (const PlaneStress& s : stress) result.shear_stress.push_back(s[3]);
  result.pressure_on_front_error = pressure_error(body, stress, run, result.solid_elements);
  measure(body, stress, result);
  result.mesh = std::move(body.mesh);
  return result;
}

}  // namespace

T1Result run_t1(const T1Run& run) {
  switch (run.element) {
    case mesh::ElementKind::p1:
      return solve<fem::P1Triangle>(run);
    case mesh::ElementKind::q1:
      return solve<fem::Q1Quadrilateral>(run);
    case mesh::ElementKind::q1_bending:
      return solve<fem::BendingQuadrilateral>(run);
  }
  throw std::logic_error("run_t1: an element without forms");
}

}  // namespace dccast::verification
