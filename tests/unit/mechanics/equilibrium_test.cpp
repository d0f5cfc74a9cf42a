#include "core/mechanics/equilibrium.hpp"

#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

template <class Element>
class EquilibriumOf : public ::testing::Test {
protected:
  EquilibriumOf() : body(distorted_rectangle<Element>(0.3, 0.2, 3, 3)) {
    body.set_material(4e10, 0.45, 0.0, 6.0);
    body.problem.dt = 1.0;
  }

  /// Creep in every element, from weak to strong; strains that carry no stress; thermal strain.
  void fill_history() {
    for (std::size_t e = 0; e < body.problem.kappa.size(); ++e) {
      body.problem.kappa[e] = std::pow(10.0, -42.0 + static_cast<double>(e % 7));
      body.problem.thermal[e] = 1e-3 * std::sin(static_cast<double>(e));
      body.problem.prestress[e] = -1e4 * static_cast<double>(e);
    }
    for (std::size_t i = 0; i < body.problem.inelastic.size(); ++i) {
      const double s = static_cast<double>(i);
      body.problem.inelastic[i] = {
          {1e-4 * std::sin(s), 1e-4 * std::cos(s), -5e-5, 1e-4 * std::sin(2 * s)}};
    }
  }

  std::vector<double> wavy(double amplitude, double phase) const {
    std::vector<double> u(body.problem.unknowns());
    for (std::size_t i = 0; i < u.size(); ++i) u[i] = amplitude * std::sin(1.7 * double(i) + phase);
    return u;
  }

  std::vector<double> residual(const std::vector<double>& u) {
    std::vector<double> r(u.size());
    Equilibrium equilibrium(body.problem);
    equilibrium.residual(u, r, return_map_law(body.problem));
    return r;
  }

  FixedBody<Element> body;
};

using Families =
    ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::BendingQuadrilateral,
                     fem::AxisymmetricP1, fem::AxisymmetricQ1, fem::AxisymmetricBending>;
TYPED_TEST_SUITE(EquilibriumOf, Families);

/// Tests of bodies that may rotate in their plane.
template <class Element>
class PlaneEquilibriumOf : public EquilibriumOf<Element> {};
using PlaneFamilies =
    ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::BendingQuadrilateral>;
TYPED_TEST_SUITE(PlaneEquilibriumOf, PlaneFamilies);

TYPED_TEST(EquilibriumOf, TangentMeetsDifferencesAtTheExpectedOrder) {
  this->fill_history();
  const auto u = this->wavy(1e-4, 0.2), direction = this->wavy(1e-4, 1.1);
  Equilibrium equilibrium(this->body.problem);
  std::vector<double> unused(u.size()), product(u.size());
  std::vector<double> stiffness(this->body.pattern.entries());
  equilibrium.residual(u, unused, return_map_law(this->body.problem));
  equilibrium.tangent(stiffness);
  linalg::multiply(this->body.pattern, stiffness, direction, product);
  const auto error = [&](double h) {
    auto ahead = u, behind = u;
    for (std::size_t i = 0; i < u.size(); ++i)
      ahead[i] += h * direction[i], behind[i] -= h * direction[i];
    const auto more = this->residual(ahead), less = this->residual(behind);
    double sum = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      const double d = (more[i] - less[i]) / (2.0 * h) - product[i];
      sum += d * d, scale += product[i] * product[i];
    }
    return std::sqrt(sum / scale);
  };

  EXPECT_NEAR(error(0.02) / error(0.01), 4.0, 0.1);
  EXPECT_LE(error(1e-4), 1e-6);
}

TYPED_TEST(PlaneEquilibriumOf, InternalForcesAreInBalanceAmongThemselves) {
  this->fill_history();
  const auto r = this->residual(this->wavy(1e-4, 0.2));
  double force[2] = {0.0, 0.0}, moment = 0.0, scale = 0.0;
  for (int n = 0; n < this->body.mesh.nodes(); ++n) {
    const double *x = this->body.mesh.point(n), *f = &r[2 * std::size_t(n)];
    force[0] += f[0], force[1] += f[1];
    moment += x[0] * f[1] - x[1] * f[0];
    scale += std::abs(f[0]) + std::abs(f[1]);
  }
  EXPECT_LE(std::abs(force[0]) + std::abs(force[1]), 1e-14 * scale);
  EXPECT_LE(std::abs(moment), 1e-14 * scale);
}

TYPED_TEST(PlaneEquilibriumOf, ARigidRotationLeavesNoStress) {
  constexpr double angle = 1e-3;
  std::vector<double> u;
  for (int n = 0; n < this->body.mesh.nodes(); ++n) {
    const double* x = this->body.mesh.point(n);
    u.insert(u.end(), {-angle * x[1] + 0.01, angle * x[0] - 0.02});
  }
  std::vector<double> r(u.size());
  Equilibrium equilibrium(this->body.problem);
  equilibrium.residual(u, r, return_map_law(this->body.problem));

  for (const auto& deviator : equilibrium.deviators())
    EXPECT_LE(deviator.norm(), 1e-12 * 4e10 * angle);
  for (int e = 0; e < this->body.mesh.elements(); ++e) {
    EXPECT_LE(std::abs(mean_normal_stress(this->body.problem, e, u)), 1e-12 * 1e11 * angle);
  }
}

constexpr double density = 2360.0, gravity = 9.81;

/// Liquid under p = -rho g (h - y): with the pressure of each element's centroid the forces balance
/// the weight at every node that can move.
TEST(FictitiousLiquid, ItsPressureCarriesItsWeight) {
  constexpr double height = 0.2;
  const auto check = [&]<class Element>(FixedBody<Element>& body) {
    // Prestress of each element by the depth of its centroid.
    for (int e = 0; e < body.mesh.elements(); ++e) {
      double y = 0.0;
      for (int i = 0; i < Element::nodes; ++i) {
        y += body.mesh.point(body.mesh.nodes_of(e)[i])[1] / Element::nodes;
      }
      body.problem.prestress[std::size_t(e)] = -density * gravity * (height - y);
    }

    body.problem.dt = 1.0;
    body.add_body_force([](double, double) { return Vector2{0.0, -density * gravity}; });

    std::vector<double> u(body.problem.unknowns(), 0.0), r(u.size());
    Equilibrium equilibrium(body.problem);
    const double acting = equilibrium.residual(u, r, return_map_law(body.problem));

    // Supported nodes carry the weight; free ones are in balance.
    double reaction = 0.0;
    for (int n = 0; n < body.mesh.nodes(); ++n) {
      const double* x = body.mesh.point(n);
      if (x[1] == 0.0) reaction += r[2 * std::size_t(n) + 1];
      if (x[1] > 0.0) {
        EXPECT_NEAR(r[2 * std::size_t(n) + 1], 0.0, 1e-14 * acting);
      }
      if (x[0] > 0.0 && x[0] < 0.3) {
        EXPECT_NEAR(r[2 * std::size_t(n)], 0.0, 1e-14 * acting);
      }
    }

    EXPECT_NEAR(reaction, density * gravity * 0.3 * height, 1e-12 * reaction);
  };

  FixedBody<fem::P1Triangle> triangles(distorted_rectangle<fem::P1Triangle>(0.3, height, 5, 4));
  check(triangles);
  FixedBody<fem::Q1Quadrilateral> squares(
      verification::uniform_rectangle(0.3, height, 5, 4, mesh::ElementKind::q1));
  check(squares);
}

}  // namespace
}  // namespace dccast::mechanics
