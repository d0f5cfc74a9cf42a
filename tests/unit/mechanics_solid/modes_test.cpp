#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/unit/mechanics_solid/solid_body.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

/// One element with these corners.
BoxMesh one_cell(const std::vector<Vector3>& corners) {
  BoxMesh box;
  box.cells = {1, 1, 1};
  box.mesh.nodes_per_element = int(corners.size());
  for (const Vector3& x : corners) {
    box.mesh.element_node.push_back(box.mesh.nodes());
    box.mesh.node.insert(box.mesh.node.end(), x.begin(), x.end());
  }
  return box;
}

template <class Element>
Eigen::MatrixXd stiffness_of_cell(const std::vector<Vector3>& corners, double poisson) {
  SolidBody<Element> body(one_cell(corners));
  body.set_material(1.0, poisson);
  std::vector<double> u(body.problem.unknowns(), 0.0), column(u.size());
  std::vector<double> values(body.pattern.entries());
  Equilibrium equilibrium(body.problem);
  equilibrium.residual(u, column, return_map_law(body.problem));
  equilibrium.tangent(values);
  Eigen::MatrixXd k(u.size(), u.size());
  for (std::size_t i = 0; i < u.size(); ++i) {
    u[i] = 1.0;
    linalg::multiply(body.pattern, values, u, column);
    u[i] = 0.0;
    k.col(long(i)) = Eigen::Map<const Eigen::VectorXd>(column.data(), k.rows());
  }
  return k;
}

std::vector<Vector3> brick(const Vector3& size) {
  std::vector<Vector3> corners;
  for (const auto& c : fem::detail::corner) {
    corners.push_back({0.5 * size[0] * c[0], 0.5 * size[1] * c[1], 0.5 * size[2] * c[2]});
  }
  return corners;
}
/// Every corner moved, no face plane.
std::vector<Vector3> distorted() {
  auto corners = brick({1.0, 2.0, 3.0});
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t d = 0; d < 3; ++d) {
      corners[i][d] += 0.25 * std::sin(7.0 * double(i) + 3.0 * double(d) + 1.0);
    }
  }
  return corners;
}
/// A parallelepiped whose axes are 45 degrees off.
std::vector<Vector3> slanted() {
  auto corners = brick({2.0, 1.0, 1.0});
  for (Vector3& x : corners) x = {x[0] + x[2], x[1] + 0.7 * x[0], x[2]};
  return corners;
}

int modes_without_energy(const Eigen::MatrixXd& k) {
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
  return int((values.array().abs() < 1e-12 * values.maxCoeff()).count());
}

template <class Element>
class SolidModesOf : public ::testing::Test {};
using Hexahedra = ::testing::Types<fem::Q1Hexahedron, fem::BendingHexahedron>;
TYPED_TEST_SUITE(SolidModesOf, Hexahedra);

/// Three translations and three rotations, and no hourglass, whatever the shape of the cell and
/// Poisson's ratio.
TYPED_TEST(SolidModesOf, OnlyRigidBodiesMoveWithoutEnergy) {
  for (const auto& corners : {distorted(), slanted(), brick({10, 1, 1}), brick({10, 5, 0.5})}) {
    for (const double poisson : {0.0, 0.45, 0.4999}) {
      EXPECT_EQ(modes_without_energy(stiffness_of_cell<TypeParam>(corners, poisson)), 6);
    }
  }
}

TEST(P1Tetrahedron, OnlyRigidBodiesMoveWithoutEnergy) {
  const std::vector<Vector3> corners{{0, 0, 0}, {1, 0.1, 0}, {0.2, 1, -0.1}, {0.3, 0.2, 1}};
  EXPECT_EQ(modes_without_energy(stiffness_of_cell<fem::P1Tetrahedron>(corners, 0.45)), 6);
}

/// The softest isochoric deformation of a cube has at least a tenth of the stiffness of a uniform
/// shear: an element with too soft hourglass modes would give solutions polluted by hourglass
/// patterns.
TEST(BendingHexahedron, HasNoSoftHourglass) {
  const auto k = stiffness_of_cell<fem::BendingHexahedron>(brick({1, 1, 1}), 0.45);
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
  Eigen::VectorXd shear = Eigen::VectorXd::Zero(24);
  for (std::size_t i = 0; i < 8; ++i) shear(long(3 * i)) = fem::detail::corner[i][1];
  const double of_shear = shear.dot(k * shear) / shear.squaredNorm();
  EXPECT_GE(values(6), 0.1 * of_shear);
}

/// Turned in space, a cell has the same stiffness, turned.
TEST(BendingHexahedron, DoesNotKnowTheAxes) {
  Eigen::Matrix3d turn;
  for (int d = 0; d < 3; ++d) {
    Vector3 unit{};
    unit[std::size_t(d)] = 1.0;
    const Vector3 t = turned(unit);
    turn.col(d) = Eigen::Map<const Eigen::Vector3d>(t.data());
  }
  Eigen::MatrixXd of_nodes = Eigen::MatrixXd::Zero(24, 24);
  auto corners = distorted();
  for (long n = 0; n < 8; ++n) {
    of_nodes.block<3, 3>(3 * n, 3 * n) = turn;
    corners[std::size_t(n)] = turned(corners[std::size_t(n)]);
  }
  const auto k = stiffness_of_cell<fem::BendingHexahedron>(distorted(), 0.3);
  const auto of_turned = stiffness_of_cell<fem::BendingHexahedron>(corners, 0.3);
  EXPECT_LE((of_nodes.transpose() * of_turned * of_nodes - k).norm(), 1e-13 * k.norm());
}

/// The stiffness does not depend on the corner at which the numbering of a cell begins: rotations
/// of the numbering by a third of a turn about the diagonal and by a quarter of a turn about an
/// axis.
TEST(BendingHexahedron, DoesNotKnowItsFirstCorner) {
  const auto corners = distorted();
  const auto k = stiffness_of_cell<fem::BendingHexahedron>(corners, 0.3);
  for (const auto& order :
       {std::array{0, 3, 7, 4, 1, 2, 6, 5}, std::array{1, 2, 3, 0, 5, 6, 7, 4}}) {
    std::vector<Vector3> renumbered;
    Eigen::MatrixXd permutation = Eigen::MatrixXd::Zero(24, 24);
    for (long i = 0; i < 8; ++i) {
      const int old = order[std::size_t(i)];
      renumbered.push_back(corners[std::size_t(old)]);
      permutation.block<3, 3>(3 * i, 3 * old).setIdentity();
    }
    const auto other = stiffness_of_cell<fem::BendingHexahedron>(renumbered, 0.3);
    EXPECT_LE((permutation.transpose() * other * permutation - k).norm(), 1e-13 * k.norm());
  }
}

}  // namespace
}  // namespace dccast::mechanics
