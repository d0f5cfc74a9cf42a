#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

template <int Dim>
using Corners = std::vector<Vector<Dim>>;

template <class Element, int Dim = Element::dimension>
Eigen::MatrixXd stiffness_of_cell(const Corners<Dim>& corners, double poisson) {
  mesh::Mesh<Dim> mesh;
  mesh.nodes_per_element = int(corners.size());
  for (const auto& x : corners) {
    mesh.element_node.push_back(mesh.nodes());
    mesh.node.insert(mesh.node.end(), x.begin(), x.end());
  }
  FixedBody<Element> body(std::move(mesh));
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

Corners<3> brick(const Vector3& size) {
  Corners<3> corners;
  for (const auto& c : fem::detail::corner) {
    corners.push_back({0.5 * size[0] * c[0], 0.5 * size[1] * c[1], 0.5 * size[2] * c[2]});
  }
  return corners;
}
/// A cell of which no faces are parallel, and in three dimensions none is plane.
template <int Dim>
Corners<Dim> distorted() {
  if constexpr (Dim == 2) {
    return {{0.1, 0.0}, {2.1, 0.3}, {1.8, 1.9}, {0.3, 1.1}};
  } else {
    auto corners = brick({1.0, 2.0, 3.0});
    for (std::size_t i = 0; i < 8; ++i) {
      for (std::size_t d = 0; d < 3; ++d) {
        corners[i][d] += 0.25 * std::sin(7.0 * double(i) + 3.0 * double(d) + 1.0);
      }
    }
    return corners;
  }
}
/// A parallelepiped whose axes are 45 degrees off.
Corners<3> slanted() {
  auto corners = brick({2.0, 1.0, 1.0});
  for (Vector3& x : corners) x = {x[0] + x[2], x[1] + 0.7 * x[0], x[2]};
  return corners;
}

int modes_without_energy(const Eigen::MatrixXd& k) {
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
  return int((values.array().abs() < 1e-12 * values.maxCoeff()).count());
}

template <class Element>
class ModesOf : public ::testing::Test {
protected:
  static std::vector<Corners<Element::dimension>> cells() {
    if constexpr (Element::dimension == 2) {
      return {distorted<2>(), {{0.5, 0.0}, {10.5, 0.0}, {10.5, 1.0}, {0.5, 1.0}}};
    } else {
      return {distorted<3>(), slanted(), brick({10, 1, 1}), brick({10, 5, 0.5})};
    }
  }
};
using Blocks =
    ::testing::Types<fem::Q1Quadrilateral, fem::BendingQuadrilateral, fem::AxisymmetricQ1,
                     fem::AxisymmetricBending, fem::Q1Hexahedron, fem::BendingHexahedron>;
TYPED_TEST_SUITE(ModesOf, Blocks);

/// The translations and rotations of the plane or the space, a translation along the axis if
/// axisymmetric, and no hourglass, whatever the shape of the cell and Poisson's ratio.
TYPED_TEST(ModesOf, OnlyRigidBodiesMoveWithoutEnergy) {
  const int rigid = fem::is_axisymmetric<TypeParam> ? 1 : TypeParam::dimension == 2 ? 3 : 6;
  for (const auto& corners : this->cells()) {
    for (const double poisson : {0.0, 0.45, 0.4999}) {
      EXPECT_EQ(modes_without_energy(stiffness_of_cell<TypeParam>(corners, poisson)), rigid);
    }
  }
}

TEST(P1Tetrahedron, OnlyRigidBodiesMoveWithoutEnergy) {
  const Corners<3> corners{{0, 0, 0}, {1, 0.1, 0}, {0.2, 1, -0.1}, {0.3, 0.2, 1}};
  EXPECT_EQ(modes_without_energy(stiffness_of_cell<fem::P1Tetrahedron>(corners, 0.45)), 6);
}

/// The hourglass modes of a square cell have a minimum stiffness: an element with too soft
/// hourglass modes would give solutions polluted by hourglass patterns.
TEST(BendingQuadrilateral, HasNoSoftHourglass) {
  const Corners<2> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  Eigen::VectorXd hourglass = Eigen::VectorXd::Zero(8);
  hourglass << 1, 0, -1, 0, 1, 0, -1, 0;
  const auto energy = [&](const Eigen::MatrixXd& k) { return hourglass.dot(k * hourglass); };
  EXPECT_GE(energy(stiffness_of_cell<fem::BendingQuadrilateral>(square, 0.45)),
            energy(stiffness_of_cell<fem::Q1Quadrilateral>(square, 0.45)));
}

/// The softest isochoric deformation of a cube has at least a tenth of the stiffness of a uniform
/// shear.
TEST(BendingHexahedron, HasNoSoftHourglass) {
  const auto k = stiffness_of_cell<fem::BendingHexahedron>(brick({1, 1, 1}), 0.45);
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
  Eigen::VectorXd shear = Eigen::VectorXd::Zero(24);
  for (std::size_t i = 0; i < 8; ++i) shear(long(3 * i)) = fem::detail::corner[i][1];
  const double of_shear = shear.dot(k * shear) / shear.squaredNorm();
  EXPECT_GE(values(6), 0.1 * of_shear);
}

template <class Element>
class BendingCell : public ::testing::Test {
protected:
  static constexpr int dimension = Element::dimension, nodes = Element::nodes;
  static constexpr double round_off = dimension == 2 ? 1e-14 : 1e-13;

  static Eigen::MatrixXd stiffness(const Corners<dimension>& corners) {
    return stiffness_of_cell<Element>(corners, 0.3);
  }
};
using BendingElements = ::testing::Types<fem::BendingQuadrilateral, fem::BendingHexahedron>;
TYPED_TEST_SUITE(BendingCell, BendingElements);

/// Turned, a cell has the same stiffness, turned.
TYPED_TEST(BendingCell, DoesNotKnowTheAxes) {
  constexpr int dim = TypeParam::dimension, unknowns = dim * TypeParam::nodes;
  const auto turn = rotation<dim>();
  Eigen::MatrixXd of_nodes = Eigen::MatrixXd::Zero(unknowns, unknowns);
  auto corners = distorted<dim>();
  for (long n = 0; n < TypeParam::nodes; ++n) {
    of_nodes.template block<dim, dim>(dim * n, dim * n) = turn;
    Eigen::Map<Eigen::Matrix<double, dim, 1>> x(corners[std::size_t(n)].data());
    x = (turn * x).eval();
  }
  const auto k = this->stiffness(distorted<dim>());
  const auto of_turned = this->stiffness(corners);
  EXPECT_LE((of_nodes.transpose() * of_turned * of_nodes - k).norm(), this->round_off * k.norm());
}

/// The stiffness does not depend on the corner at which the numbering of a cell begins: rotations
/// of the numbering by a quarter of a turn about an axis, in space also by a third of a turn about
/// the diagonal.
TYPED_TEST(BendingCell, DoesNotKnowItsFirstCorner) {
  constexpr int dim = TypeParam::dimension, unknowns = dim * TypeParam::nodes;
  const std::vector<std::vector<int>> orders =
      dim == 2 ? std::vector<std::vector<int>>{{1, 2, 3, 0}}
               : std::vector<std::vector<int>>{{0, 3, 7, 4, 1, 2, 6, 5}, {1, 2, 3, 0, 5, 6, 7, 4}};
  const auto corners = distorted<dim>();
  const auto k = this->stiffness(corners);
  for (const auto& order : orders) {
    Corners<dim> renumbered;
    Eigen::MatrixXd permutation = Eigen::MatrixXd::Zero(unknowns, unknowns);
    for (std::size_t i = 0; i < order.size(); ++i) {
      renumbered.push_back(corners[std::size_t(order[i])]);
      permutation.template block<dim, dim>(dim * long(i), dim * order[i]).setIdentity();
    }
    const auto other = this->stiffness(renumbered);
    EXPECT_LE((permutation.transpose() * other * permutation - k).norm(),
              this->round_off * k.norm());
  }
}

}  // namespace
}  // namespace dccast::mechanics
