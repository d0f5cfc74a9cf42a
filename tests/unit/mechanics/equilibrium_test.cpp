#include "core/mechanics/equilibrium.hpp"

#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

template <class Element>
class EquilibriumOf : public ::testing::Test {
protected:
  EquilibriumOf() : body_(small_distorted_box<Element>()) { body_.set_material(4e10, 0.45); }

  /// Creep in every element, from weak to strong; strains that carry no stress; thermal strain.
  void fill_history() {
    for (std::size_t e = 0; e < body_.problem.kappa.size(); ++e) {
      body_.problem.kappa[e] = std::pow(10.0, -42.0 + static_cast<double>(e % 7));
      body_.problem.thermal[e] = 1e-3 * std::sin(static_cast<double>(e));
      body_.problem.prestress[e] = -1e4 * static_cast<double>(e);
    }
    for (std::size_t i = 0; i < body_.problem.inelastic.size(); ++i) {
      for (std::size_t c = 0; c < body_.problem.inelastic[i].components; ++c) {
        body_.problem.inelastic[i][c] = 1e-4 * std::sin(double(i) + 1.3 * double(c));
      }
    }
  }

  std::vector<double> wavy(double amplitude, double phase) const {
    std::vector<double> u(body_.problem.unknowns());
    for (std::size_t i = 0; i < u.size(); ++i) u[i] = amplitude * std::sin(1.7 * double(i) + phase);
    return u;
  }

  FixedBody<Element> body_;
};
TYPED_TEST_SUITE(EquilibriumOf, AllFamilies);

/// Tests of bodies that may rotate.
template <class Element>
class FreeEquilibriumOf : public EquilibriumOf<Element> {};
TYPED_TEST_SUITE(FreeEquilibriumOf, FreeFamilies);

TYPED_TEST(EquilibriumOf, TangentMeetsDifferencesAtTheExpectedOrder) {
  this->fill_history();
  auto& body = this->body_;
  const auto u = this->wavy(1e-4, 0.2), direction = this->wavy(1e-4, 1.1);
  Equilibrium equilibrium(body.problem);
  std::vector<double> unused(u.size()), product(u.size()), stiffness(body.pattern.entries());
  equilibrium.residual(u, unused, return_map_law(body.problem));
  equilibrium.tangent(stiffness);
  linalg::multiply(body.pattern, stiffness, direction, product);

  const auto error = [&](double h) {
    auto ahead = u, behind = u;
    for (std::size_t i = 0; i < u.size(); ++i) {
      ahead[i] += h * direction[i], behind[i] -= h * direction[i];
    }
    auto slope = body.residual(ahead);
    const auto less = body.residual(behind);
    for (std::size_t i = 0; i < u.size(); ++i) slope[i] = (slope[i] - less[i]) / (2.0 * h);
    return relative_difference(slope, product);
  };
  EXPECT_NEAR(error(0.02) / error(0.01), 4.0, 0.1);
  EXPECT_LE(error(1e-4), 1e-6);
}

TYPED_TEST(FreeEquilibriumOf, InternalForcesAreInBalanceAmongThemselves) {
  this->fill_history();
  const auto r = this->body_.residual(this->wavy(1e-4, 0.2));
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = force;
  double scale = 0.0;
  for (int n = 0; n < this->body_.mesh.nodes(); ++n) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero(), f = x;
    for (int d = 0; d < TypeParam::dimension; ++d) {
      x(d) = this->body_.mesh.point(n)[d];
      f(d) = r[std::size_t(TypeParam::dimension * n + d)];
    }
    force += f, moment += x.cross(f), scale += f.norm();
  }
  EXPECT_LE(force.norm(), 1e-14 * scale);
  EXPECT_LE(moment.norm(), 1e-14 * scale);
}

TYPED_TEST(FreeEquilibriumOf, ARigidRotationLeavesNoStress) {
  constexpr double angle = 1e-3;
  constexpr double spin[3][3] = {{0, -angle, 2 * angle}, {angle, 0, 0}, {-2 * angle, 0, 0}};
  constexpr double shift[] = {0.01, -0.02, 0.0};
  std::vector<double> u;
  for (int n = 0; n < this->body_.mesh.nodes(); ++n) {
    for (int a = 0; a < TypeParam::dimension; ++a) {
      u.push_back(shift[a]);
      for (int b = 0; b < TypeParam::dimension; ++b)
        u.back() += spin[a][b] * this->body_.mesh.point(n)[b];
    }
  }
  std::vector<double> r(u.size());
  Equilibrium equilibrium(this->body_.problem);
  equilibrium.residual(u, r, return_map_law(this->body_.problem));

  for (const auto& deviator : equilibrium.deviators())
    EXPECT_LE(deviator.norm(), 1e-12 * 4e10 * angle);
  for (int e = 0; e < this->body_.mesh.elements(); ++e) {
    EXPECT_LE(std::abs(mean_normal_stress(this->body_.problem, e, u)), 1e-12 * 1e11 * angle);
  }
}

/// The forces of the forms are the derivative of the strains: work of stresses on strains is work
/// of forces on displacements.
TYPED_TEST(EquilibriumOf, ForcesDoTheWorkOfTheStresses) {
  this->fill_history();
  auto& body = this->body_;
  const auto u = this->wavy(1e-4, 0.2), virtual_u = this->wavy(1e-4, 1.1);
  Equilibrium equilibrium(body.problem);
  std::vector<double> r(u.size());
  equilibrium.residual(u, r, return_map_law(body.problem));
  double outer = 0.0, inner = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) outer += r[i] * virtual_u[i];

  for (std::size_t e = 0; e < body.forms.elements(); ++e) {
    const auto& cell = body.forms.geometry().cell(int(e));
    for (std::size_t q = 0; q < body.forms.points(); ++q) {
      const auto s = equilibrium.deviator(e * body.forms.points() + q);
      const auto strain = body.forms.strain(e, q, virtual_u);
      double work = 0.0;
      for (std::size_t c = 0; c < s.components; ++c) work += (c < 3 ? 1.0 : 2.0) * s[c] * strain[c];
      // The pressure at a point holds its own inelastic trace.
      const auto& inelastic = body.problem.inelastic[e * body.forms.points() + q];
      const double dilatation =
          body.forms.mean_dilatation(e, u) - inelastic.trace() - 3.0 * body.problem.thermal[e];
      work += (body.problem.bulk[e] * dilatation + body.problem.prestress[e]) * strain.trace();
      inner += cell.point[q].weight * work;
    }
  }
  EXPECT_NEAR(outer, inner, 1e-12 * std::abs(inner));
}

constexpr double density = 2360.0, gravity = 9.81;

/// Liquid under p = -rho g (h - y): with the pressure of each element's centroid the forces balance
/// the weight at every node that can move.
TEST(FictitiousLiquid, ItsPressureCarriesItsWeight) {
  constexpr double height = 0.2;
  const auto check = [&]<class Element>(FixedBody<Element>& body) {
    for (int e = 0; e < body.mesh.elements(); ++e) {
      body.problem.prestress[std::size_t(e)] =
          -density * gravity * (height - height_of(body.mesh, e));
    }
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

  FixedBody<fem::P1Triangle> triangles(distorted_box<fem::P1Triangle>({0.3, height}, {5, 4}));
  check(triangles);
  FixedBody<fem::Q1Quadrilateral> squares(box<fem::Q1Quadrilateral>({0.3, height}, {5, 4}));
  check(squares);
}

}  // namespace
}  // namespace dccast::mechanics
