#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

constexpr double young = 4e10, poisson = 0.45, exponent = 6.0;
constexpr double mu = young / (2.0 * (1.0 + poisson));
constexpr double bulk = young / (3.0 * (1.0 - 2.0 * poisson));
constexpr double gradient[3][3] = {
    {2e-3, -7e-4, 4e-4}, {1e-3, -1.5e-3, 9e-4}, {-6e-4, 3e-4, 1.2e-3}};

/// A linear displacement on the boundary of a distorted mesh, turned unless it has an axis: the
/// same inside, one stress everywhere.
template <class Element>
class PatchOf : public ::testing::Test {
protected:
  static constexpr int dimension = Element::dimension;
  static constexpr std::size_t dim = dimension;
  static constexpr bool round = fem::is_axisymmetric<Element>;
  using Tensor = SymmetricTensor<dimension>;
  using Place = Vector<dimension>;

  PatchOf() : body(shape()) {
    hold_boundary(body, [](auto... x) { return linear(Place{x...}); });
  }

  static mesh::Mesh<dimension> shape() {
    if constexpr (round) {
      return distorted_box<Element>({0.3, 0.2}, {4, 4});
    } else if constexpr (dimension == 2) {
      return turned(distorted_box<Element>({0.3, 0.2}, {4, 4}));
    } else {
      return turned(distorted_box<Element>({0.3, 0.2, 0.4}, {3, 3, 4}));
    }
  }
  static mesh::Mesh<dimension> turned(mesh::Mesh<dimension> mesh) {
    for (int n = 0; n < mesh.nodes(); ++n) {
      Eigen::Map<Eigen::Matrix<double, dimension, 1>> x(&mesh.node[dim * std::size_t(n)]);
      x = (rotation<dimension>() * x).eval();
    }
    return mesh;
  }

  /// Of a billet a swelling and a stretch along the axis.
  static double slope(std::size_t a, std::size_t b) {
    return round && a != b ? 0.0 : gradient[a][b];
  }
  static Place linear(const Place& x) {
    constexpr double shift[] = {1e-4, -3e-4, 2e-4};
    Place u{};
    for (std::size_t a = 0; a < dim; ++a) {
      u[a] = round && a == 0 ? 0.0 : shift[a];
      for (std::size_t b = 0; b < dim; ++b) u[a] += slope(a, b) * x[b];
    }
    return u;
  }
  static Tensor strain() {
    Tensor e;
    for (std::size_t a = 0; a < dim; ++a) {
      for (std::size_t b = a; b < dim; ++b) {
        e[Tensor::index(a, b)] = 0.5 * (slope(a, b) + slope(b, a));
      }
    }
    if (round) e[2] = e[0];  // a swelling stretches around as much as across
    return e;
  }

  void expect_constant(const Tensor& exact) {
    const auto outcome = body.step(tight());
    ASSERT_TRUE(outcome.converged) << outcome.equilibrium_residual;
    for (int n = 0; n < body.mesh.nodes(); ++n) {
      const Place u = linear(body.place(n));
      for (int d = 0; d < dimension; ++d) {
        EXPECT_NEAR(body.displacement(n, d), u[std::size_t(d)], 1e-12 * 1e-3);
      }
    }
    // stress() shows the pressure of the end of the step; creep has no volume.
    for (const Tensor& stress : body.stresses()) {
      EXPECT_LE(difference(stress, exact).norm(), (dimension == 2 ? 1e-12 : 1e-11) * exact.norm());
    }
  }

  static Tensor elastic(double thermal) {
    Tensor stress;
    stress.add(2.0 * mu, strain().deviator());
    return stress.add_identity(bulk * (strain().trace() - 3.0 * thermal));
  }

  FixedBody<Element> body;
};
TYPED_TEST_SUITE(PatchOf, AllFamilies);

TYPED_TEST(PatchOf, Elastic) {
  this->body.set_material(young, poisson);
  this->expect_constant(this->elastic(0.0));
}

TYPED_TEST(PatchOf, WithThermalStrain) {
  this->body.set_material(young, poisson);
  std::fill(this->body.problem.thermal.begin(), this->body.problem.thermal.end(), -0.02);
  this->expect_constant(this->elastic(-0.02));
}

TYPED_TEST(PatchOf, NearlyIncompressible) {
  constexpr double almost_half = 0.4999;
  this->body.set_material(young, almost_half);
  typename TestFixture::Tensor exact;
  exact.add(young / (1.0 + almost_half), this->strain().deviator());
  exact.add_identity(young / (3.0 * (1.0 - 2.0 * almost_half)) * this->strain().trace());
  this->expect_constant(exact);
}

TYPED_TEST(PatchOf, WithCreep) {
  constexpr double kappa = 1e-38;
  this->body.set_material(young, poisson, kappa, exponent);
  std::fill(this->body.problem.thermal.begin(), this->body.problem.thermal.end(), -1e-3);
  // |s| by bisection, so that nothing of the return map checks itself.
  const auto strain = this->strain();
  const double trial = 2.0 * mu * strain.deviator().norm();
  double low = 0.0, high = trial;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (middle + 2.0 * mu * kappa * std::pow(middle, 5.0) < trial ? low : high) = middle;
  }
  ASSERT_LT(low, 0.9 * trial) << "creep must matter here";

  typename TestFixture::Tensor exact;
  exact.add(low / strain.deviator().norm(), strain.deviator());
  exact.add_identity(bulk * (strain.trace() + 3e-3));
  this->expect_constant(exact);
}

/// Strain that carries no stress, half of the strain itself, leaves half of the stress.
TYPED_TEST(PatchOf, WithInelasticStrain) {
  this->body.set_material(young, poisson);
  typename TestFixture::Tensor half, exact;
  half.add(0.5, this->strain());
  exact.add(0.5, this->elastic(0.0));
  std::fill(this->body.problem.inelastic.begin(), this->body.problem.inelastic.end(), half);
  this->expect_constant(exact);
}

}  // namespace
}  // namespace dccast::mechanics
