#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <utility>

#include "core/mechanics/constitutive.hpp"
#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;
using verification::uniform_rectangle;

/// A cell with these corners.
mesh::Mesh2D one_cell(std::vector<double> corners) {
  mesh::Mesh2D mesh;
  mesh.node = std::move(corners);
  mesh.nodes_per_element = mesh.nodes();
  for (int n = 0; n < mesh.nodes(); ++n) mesh.element_node.push_back(n);
  return mesh;
}
const std::vector<double> skewed{0.1, 0.0, 2.1, 0.3, 1.8, 1.9, 0.3, 1.1};
const std::vector<double> needle{0.5, 0.0, 10.5, 0.0, 10.5, 1.0, 0.5, 1.0};

template <class Element>
Eigen::MatrixXd stiffness_of(FixedBody<Element>& body) {
  std::vector<double> u(body.problem.unknowns(), 0.0), unused(u.size());
  std::vector<double> values(body.pattern.entries()), column(u.size());
  body.problem.dt = 1.0;
  Equilibrium equilibrium(body.problem);
  equilibrium.residual(u, unused, return_map_law(body.problem));
  equilibrium.tangent(values);
  Eigen::MatrixXd k(u.size(), u.size());
  for (std::size_t i = 0; i < u.size(); ++i) {
    u[i] = 1.0;
    linalg::multiply(body.pattern, values, u, column);
    u[i] = 0.0;
    for (std::size_t j = 0; j < column.size(); ++j) k(long(j), long(i)) = column[j];
  }
  return k;
}

template <class Element>
Eigen::MatrixXd stiffness_of_cell(const std::vector<double>& corners, double poisson) {
  FixedBody<Element> body(one_cell(corners));
  body.set_material(1.0, poisson, 0.0, 2.0);
  return stiffness_of(body);
}

int modes_without_energy(const Eigen::MatrixXd& k) {
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
  return int((values.array().abs() < 1e-12 * values.maxCoeff()).count());
}

template <class Element>
class ModesOf : public ::testing::Test {};
using Quadrilaterals = ::testing::Types<fem::Q1Quadrilateral, fem::BendingQuadrilateral,
                                        fem::AxisymmetricQ1, fem::AxisymmetricBending>;
TYPED_TEST_SUITE(ModesOf, Quadrilaterals);

/// Two translations and a rotation in the plane, a translation along the axis if axisymmetric, and
/// no hourglass, whatever the shape of the cell and Poisson's ratio.
TYPED_TEST(ModesOf, OnlyRigidBodiesMoveWithoutEnergy) {
  for (const auto& corners : {skewed, needle}) {
    for (const double poisson : {0.0, 0.45, 0.4999}) {
      EXPECT_EQ(modes_without_energy(stiffness_of_cell<TypeParam>(corners, poisson)),
                fem::is_axisymmetric<TypeParam> ? 1 : 3);
    }
  }
}

/// The hourglass modes of a square cell have a minimum stiffness: an element with too soft
/// hourglass modes would give solutions polluted by hourglass patterns.
TEST(BendingQuadrilateral, HasNoSoftHourglass) {
  const std::vector<double> square{0, 0, 1, 0, 1, 1, 0, 1};
  Eigen::VectorXd hourglass = Eigen::VectorXd::Zero(8);
  hourglass << 1, 0, -1, 0, 1, 0, -1, 0;
  const auto energy = [&](const Eigen::MatrixXd& k) { return hourglass.dot(k * hourglass); };
  EXPECT_GE(energy(stiffness_of_cell<fem::BendingQuadrilateral>(square, 0.45)),
            energy(stiffness_of_cell<fem::Q1Quadrilateral>(square, 0.45)));
}

/// Turned in its plane, a cell has the same stiffness, turned.
TEST(BendingQuadrilateral, DoesNotKnowTheAxes) {
  const double angle = 0.7, c = std::cos(angle), s = std::sin(angle);
  Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(8, 8);
  std::vector<double> turned;
  for (int n = 0; n < 4; ++n) {
    turn.block<2, 2>(2 * n, 2 * n) << c, -s, s, c;
    const double* x = &skewed[2 * std::size_t(n)];
    turned.insert(turned.end(), {c * x[0] - s * x[1], s * x[0] + c * x[1]});
  }
  const auto k = stiffness_of_cell<fem::BendingQuadrilateral>(skewed, 0.3);
  const auto of_turned = stiffness_of_cell<fem::BendingQuadrilateral>(turned, 0.3);
  EXPECT_LE((turn.transpose() * of_turned * turn - k).norm(), 1e-14 * k.norm());
}

/// The stiffness does not depend on the corner at which the numbering of a cell begins.
TEST(BendingQuadrilateral, DoesNotKnowItsFirstCorner) {
  std::vector<double> rolled(skewed.begin() + 2, skewed.end());
  rolled.insert(rolled.end(), skewed.begin(), skewed.begin() + 2);
  const auto k = stiffness_of_cell<fem::BendingQuadrilateral>(skewed, 0.3);
  const auto of_rolled = stiffness_of_cell<fem::BendingQuadrilateral>(rolled, 0.3);
  Eigen::MatrixXd roll = Eigen::MatrixXd::Zero(8, 8);
  for (int i = 0; i < 8; ++i) roll(i, (i + 2) % 8) = 1.0;
  EXPECT_LE((roll.transpose() * of_rolled * roll - k).norm(), 1e-14 * k.norm());
}

struct Plate {
  double poisson, cell;  ///< cell length over thickness
  int layers;
  double slant = 0.0;  ///< of the cells' ends [thicknesses]
};

/// Deflection of a plate bent by end moments over beam theory's. Only inner nodes are slanted.
template <class Element>
double deflection(const Plate& plate) {
  constexpr int columns = 6;
  constexpr double young = 1e9, slope = 1e6;
  const double length = plate.cell * columns;
  auto mesh = uniform_rectangle(length, 1.0, columns, plate.layers, kind_of<Element>);
  for (int n = 0; n < mesh.nodes(); ++n) {
    double* x = &mesh.node[2 * std::size_t(n)];
    if (x[0] > 0.0 && x[0] < length) x[0] += plate.slant * (x[1] - 0.5);
  }
  FixedBody<Element> body(std::move(mesh));
  body.set_material(young, plate.poisson, 0.0, 2.0);
  for (int n = 0; n < body.mesh.nodes(); n += columns + 1) body.fix(n, 0, 0.0);
  body.fix(0, 1, 0.0);
  body.add_traction(mesh::PatchKind::side, [](double, double y) {
    return Vector2{slope * (y - 0.5), 0.0};
  });
  EXPECT_TRUE(body.step(tight(1e-8), 1.0).converged);
  const double exact =
      -slope * length * length * (1.0 - plate.poisson * plate.poisson) / (2.0 * young);
  return body.displacement()[2 * columns + 1] / exact;
}

/// Nearly incompressible deformation is in the space of the element: one layer of cells ten times
/// longer than thick has the exact deflection in the limit of a Poisson's ratio of one half.
TEST(BendingQuadrilateral, OneLayerOfLongCellsBendsAtConstantVolume) {
  for (const double cell : {1.0, 2.75, 5.5, 10.0}) {
    EXPECT_NEAR(deflection<fem::BendingQuadrilateral>({0.4999, cell, 1}), 1.0, 1e-3) << cell;
  }
}

/// At other ratios the element is too stiff because of the volumetric stiffness within a layer,
/// independently of the length: by 9 % at Poisson's ratio 0.45 and 29 % at 0.3, divided by the
/// square of the number of layers.
TEST(BendingQuadrilateral, LayersBringTheRestWhateverTheLength) {
  for (const double cell : {1.0, 2.75, 5.5, 10.0}) {
    EXPECT_NEAR(deflection<fem::BendingQuadrilateral>({0.45, cell, 1}), 0.909, 1e-3) << cell;
    EXPECT_NEAR(deflection<fem::BendingQuadrilateral>({0.45, cell, 4}), 0.994, 1e-3) << cell;
    EXPECT_NEAR(deflection<fem::BendingQuadrilateral>({0.3, cell, 1}), 0.714, 1e-3) << cell;
    EXPECT_NEAR(deflection<fem::BendingQuadrilateral>({0.3, cell, 4}), 0.976, 1e-3) << cell;
  }
  EXPECT_LE(deflection<fem::Q1Quadrilateral>({0.3, 5.5, 4}), 0.1) << "Q1 locks";
}

/// Cells slanted by twice the thickness: the modes follow the axes of the cell.
TEST(BendingQuadrilateral, SlantedCellsBendToo) {
  const double straight = deflection<fem::BendingQuadrilateral>({0.3, 2.0, 2, 0.0});
  for (const double slant : {1.0, 2.0}) {
    EXPECT_NEAR(deflection<fem::BendingQuadrilateral>({0.3, 2.0, 2, slant}), straight, 0.06);
  }
  EXPECT_LE(deflection<fem::Q1Quadrilateral>({0.3, 2.0, 2, 2.0}), 0.15) << "Q1 locks";
}

/// Deflection of a round plate bent by a moment along its rim over that of thin plates, with cells
/// ten times longer than the plate is thick at the most.
template <class Element>
double deflection_of_disc(double poisson, int columns, int layers) {
  constexpr double radius = 20.0, young = 1e9, slope = 1e6;
  FixedBody<Element> body(uniform_rectangle(radius, 1.0, columns, layers, kind_of<Element>));
  body.set_material(young, poisson, 0.0, 2.0);
  for (int n = 0; n < body.mesh.nodes(); n += columns + 1) body.fix(n, 0, 0.0);
  body.fix(0, 1, 0.0);
  body.add_traction(mesh::PatchKind::side, [](double, double y) {
    return Vector2{slope * (y - 0.5), 0.0};
  });
  EXPECT_TRUE(body.step(tight(1e-8), 1.0).converged);
  const double exact = -slope * radius * radius * (1.0 - poisson) / (2.0 * young);
  return body.displacement()[2 * std::size_t(columns) + 1] / exact;
}

/// A disc bends in two directions, and its hoop strain too is balanced across the plate. What is
/// left with a few cells over the radius comes from the weight of the radius in a cell at the axis.
TEST(AxisymmetricBending, LongCellsBendInBothDirections) {
  for (const auto& [columns, error] :
       {std::pair{2, 0.12}, std::pair{4, 0.04}, std::pair{20, 0.04}}) {
    EXPECT_NEAR(deflection_of_disc<fem::AxisymmetricBending>(0.4999, columns, 1), 1.0, error)
        << columns;
    EXPECT_NEAR(deflection_of_disc<fem::AxisymmetricBending>(0.3, columns, 4), 1.0, error)
        << columns;
  }
  EXPECT_LE(deflection_of_disc<fem::AxisymmetricQ1>(0.3, 2, 4), 0.2) << "Q1 locks";
}

/// A block squeezed by a tenth of its height while it creeps, with an hourglass of strain in it at
/// the start: the hourglass of the displacement stays the size it was.
TEST(BendingQuadrilateral, AnHourglassDoesNotGrowUnderCompression) {
  constexpr int cells = 8, steps = 40;
  FixedBody<fem::BendingQuadrilateral> body(
      uniform_rectangle(1.0, 1.0, cells, cells, mesh::ElementKind::q1));
  body.set_material(4e10, 0.45, 1e-40, 6.0);

  // An hourglass of strain: its sign changes from cell to cell, its shape is the first mode.
  const auto pattern = [](int e) { return (e / cells + e % cells) % 2 == 0 ? 1.0 : -1.0; };
  for (int e = 0; e < body.mesh.elements(); ++e) {
    for (std::size_t q = 0; q < 4; ++q) {
      const auto& cell = body.forms.geometry().cell(e);
      body.problem.inelastic[4 * std::size_t(e) + q].add(1e-4 * pattern(e) * cell.point[q].lever[0],
                                                         cell.bending[0].strain);
    }
  }

  // Size of the hourglass in the displacement [m].
  const auto hourglass = [&] {
    double sum = 0.0;
    for (int e = 0; e < body.mesh.elements(); ++e) {
      for (std::size_t d = 0; d < 2; ++d) {
        double q = 0.0;
        for (int i = 0; i < 4; ++i) {
          const double sign = i % 2 == 0 ? 0.25 : -0.25;
          q += sign * body.displacement()[2 * std::size_t(body.mesh.nodes_of(e)[i]) + d];
        }
        sum += q * q;
      }
    }
    return std::sqrt(sum);
  };

  // Squeeze the block between its bottom and its top, free to spread sideways.
  double first = 0.0;
  for (int step = 1; step <= steps; ++step) {
    for (int n = 0; n < body.mesh.nodes(); ++n) {
      const double* x = body.mesh.point(n);
      if (x[1] == 0.0) body.fix(n, 1, 0.0);
      if (x[1] == 1.0) body.fix(n, 1, -0.1 * step / steps);
      if (x[0] == 0.0) body.fix(n, 0, 0.0);
    }
    ASSERT_TRUE(body.step(tight(1e-9), 1.0).converged) << step;
    if (step == 1) first = hourglass();
    EXPECT_LE(hourglass(), 1.1 * first) << step;
  }

  EXPECT_GT(first, 1e-7) << "there was one";
}

}  // namespace
}  // namespace dccast::mechanics
