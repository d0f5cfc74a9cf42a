#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

constexpr double young = 1e9, poisson = 0.35, radius = 1.0;  // of the sphere [m]
constexpr double contact_radius = 0.03;                      // [m]
constexpr double reduced = young / (1.0 - poisson * poisson);
constexpr double force =
    4.0 / 3.0 * reduced * contact_radius * contact_radius * contact_radius / radius;
constexpr double approach = contact_radius * contact_radius / radius;
const double peak_pressure = 1.5 * force / (std::numbers::pi * contact_radius * contact_radius);

/// Displacement of a half space z > 0 by a point force into it at the origin (Boussinesq).
Vector3 boussinesq(const Vector3& x) {
  const double r = std::hypot(x[0], x[1]), rho = std::hypot(r, x[2]);
  const double factor = (1.0 + poisson) * force / (2.0 * std::numbers::pi * young * rho);
  const double outwards =
      r == 0.0 ? 0.0 : factor * (x[2] / rho - (1.0 - 2.0 * poisson) * rho / (rho + x[2])) / rho;
  return {outwards * x[0], outwards * x[1],
          factor * (2.0 * (1.0 - poisson) + x[2] * x[2] / (rho * rho))};
}

/// Half of the cells lie over the contact, the others grow towards faces ten radii away, which are
/// held where a point force on the half space moves them.
double graded(double share) {
  constexpr double growth = 5.0, fine = 1.6 * contact_radius;
  if (share <= 0.5) return 2.0 * fine * share;
  return fine * (1.0 + 2.0 / growth * std::expm1(growth * (share - 0.5)));
}

template <class Element>
class SphereUnder {
public:
  explicit SphereUnder(int cells)
      : body(box_mesh({cells, cells, cells}, is_simplex<Element>, [](const Vector3& s) {
          return Vector3{graded(s[0]), graded(s[1]), graded(s[2])};
        })) {
    body.set_material(young, poisson);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (int n : mesh::patch_nodes(face(body.mesh, axis, 1.0))) {
        Vector3 u = boussinesq(body.place(n));
        u[2] -= approach;
        body.fix(n, u);
      }
    }
    hold_symmetry(body);
    body.set_contact();
    for (int unknown : body.problem.contact) {
      const Vector3 x = body.place(unknown / 3);
      body.problem.initial_gap.push_back(0.5 * (x[0] * x[0] + x[1] * x[1]) / radius);
    }
    body.problem.weight = 0.25 * force;
    EXPECT_TRUE(body.step(tight(1e-9)).converged);
    reaction = body.residual(body.displacement());
  }
  double pressure(std::size_t pair) const {
    return reaction[std::size_t(body.problem.contact[pair])] / body.problem.contact_area[pair];
  }

  FixedBody<Element> body;
  std::vector<double> reaction;
};

/// Signorini's conditions in three dimensions: load, radius of the contact and pressure of Hertz.
TEST(BendingHexahedron, MeetsHertzOverASphere) {
  constexpr int cells = 14;
  SphereUnder<fem::BendingHexahedron> sphere(cells);
  const auto& problem = sphere.body.problem;
  double total = 0.0, area = 0.0, error = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < problem.contact.size(); ++i) {
    const int unknown = problem.contact[i];
    if (problem.fixed[std::size_t(unknown)] != 0) continue;
    const Vector3 x = sphere.body.place(unknown / 3);
    const double r = std::hypot(x[0], x[1]), p = sphere.pressure(i);
    const bool closed = sphere.body.unknowns().contact[i] != 0;
    EXPECT_GE(problem.normal_gap(i, sphere.body.displacement()), -1e-10);
    EXPECT_GE(p, -1e-6 * peak_pressure);
    if (closed) {
      total += p * problem.contact_area[i], area += problem.contact_area[i];
    }
    const double share = 1.0 - r * r / (contact_radius * contact_radius);
    const double exact = share > 0.0 ? peak_pressure * std::sqrt(share) : 0.0;
    error += problem.contact_area[i] * (p - exact) * (p - exact);
    scale += problem.contact_area[i] * exact * exact;
  }
  EXPECT_NEAR(total / (0.25 * force), 1.0, 0.02);

  const double found = std::sqrt(4.0 * area / std::numbers::pi);
  EXPECT_NEAR(found, contact_radius, 0.5 * 3.2 * contact_radius / cells) << "half a cell";
  EXPECT_NEAR(sphere.pressure(0) / peak_pressure, 1.0, 0.05);
  EXPECT_LE(std::sqrt(error / scale), 0.12);
}

}  // namespace
}  // namespace dccast::mechanics
