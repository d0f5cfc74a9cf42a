#include <gtest/gtest.h>

#include "tests/unit/mechanics_solid/solid_body.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

template <class Element>
class SolidEquilibriumOf : public ::testing::Test {
protected:
  SolidEquilibriumOf() : body_(distorted_box({0.3, 0.2, 0.25}, {2, 3, 2}, of_tetrahedra<Element>)) {
    body_.set_material(4e10, 0.45);
  }

  /// Creep in every element, from weak to strong; strains that carry no stress; thermal strain.
  void fill_history() {
    for (std::size_t e = 0; e < body_.problem.kappa.size(); ++e) {
      body_.problem.kappa[e] = std::pow(10.0, -42.0 + static_cast<double>(e % 7));
      body_.problem.thermal[e] = 1e-3 * std::sin(static_cast<double>(e));
      body_.problem.prestress[e] = -1e4 * static_cast<double>(e);
    }
    for (std::size_t i = 0; i < body_.problem.inelastic.size(); ++i) {
      for (std::size_t c = 0; c < 6; ++c) {
        body_.problem.inelastic[i][c] = 1e-4 * std::sin(double(i) + 1.3 * double(c));
      }
    }
  }

  std::vector<double> wavy(double amplitude, double phase) const {
    std::vector<double> u(body_.problem.unknowns());
    for (std::size_t i = 0; i < u.size(); ++i) u[i] = amplitude * std::sin(1.7 * double(i) + phase);
    return u;
  }

  SolidBody<Element> body_;
};

using Families = ::testing::Types<fem::P1Tetrahedron, fem::Q1Hexahedron, fem::BendingHexahedron>;
TYPED_TEST_SUITE(SolidEquilibriumOf, Families);

TYPED_TEST(SolidEquilibriumOf, TangentMeetsDifferencesAtTheExpectedOrder) {
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
    const auto more = body.residual(ahead), less = body.residual(behind);
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

TYPED_TEST(SolidEquilibriumOf, InternalForcesAreInBalanceAmongThemselves) {
  this->fill_history();
  const auto r = this->body_.residual(this->wavy(1e-4, 0.2));
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = force;
  double scale = 0.0;
  for (int n = 0; n < this->body_.box.mesh.nodes(); ++n) {
    const Eigen::Map<const Eigen::Vector3d> x(this->body_.box.mesh.point(n)),
        f(&r[3 * std::size_t(n)]);
    force += f, moment += x.cross(f), scale += f.norm();
  }
  EXPECT_LE(force.norm(), 1e-14 * scale);
  EXPECT_LE(moment.norm(), 1e-14 * scale);
}

TYPED_TEST(SolidEquilibriumOf, ARigidRotationLeavesNoStress) {
  auto& body = this->body_;
  constexpr double angle = 1e-3;
  std::vector<double> u;
  for (int n = 0; n < body.box.mesh.nodes(); ++n) {
    const Vector3 x = body.place(n);
    u.insert(u.end(),
             {-angle * x[1] + 2 * angle * x[2] + 0.01, angle * x[0] - 0.02, -2 * angle * x[0]});
  }
  std::vector<double> r(u.size());
  Equilibrium equilibrium(body.problem);
  equilibrium.residual(u, r, return_map_law(body.problem));

  for (const auto& deviator : equilibrium.deviators()) {
    EXPECT_LE(deviator.norm(), 1e-12 * 4e10 * angle);
  }
  for (int e = 0; e < body.box.mesh.elements(); ++e) {
    EXPECT_LE(std::abs(mean_normal_stress(body.problem, e, u)), 1e-12 * 1e11 * angle);
  }
}

/// The forces of the forms are the derivative of the strains: work of stresses on strains is work
/// of forces on displacements.
TYPED_TEST(SolidEquilibriumOf, ForcesDoTheWorkOfTheStresses) {
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
      for (std::size_t c = 0; c < 6; ++c) work += (c < 3 ? 1.0 : 2.0) * s[c] * strain[c];
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

}  // namespace
}  // namespace dccast::mechanics
