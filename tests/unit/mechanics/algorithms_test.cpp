#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "core/mesh/extrusion.hpp"
#include "tests/unit/mechanics/resting_block.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

/// Parameters of the size of the block's own figures, as the paper's test T4 chooses them: gamma_p
/// some times the creep rate over the stress, gamma_c some times the stiffness over a cell.
Options options_of(Algorithm algorithm) {
  Options options = tight(1e-9);
  options.algorithm = algorithm;
  options.parameters.gamma_p = 1e-7;
  options.parameters.gamma_c = 4e10;
  return options;
}

template <class Element>
class AlgorithmsOn : public ::testing::Test {
public:
  /// A block that creeps, lifts its ends and comes down again.
  struct Block : RestingBlock<Element> {
    Block() : RestingBlock<Element>(2e-2, 3e-36, 2.5e6) {}
  };

protected:
  /// Displacements of a few steps.
  /// @param floor  how far the floor lies below the block at a unit distance, squared [1/m]
  std::vector<double> history(Algorithm algorithm, double floor = 0.0) {
    Block block;
    if (floor != 0.0) block.shape_floor([floor](double x) { return floor * x * x; });
    std::vector<double> all_steps;
    for (int step = 0; step < 3; ++step) {
      const auto outcome = block.body.step(options_of(algorithm), 0.05);
      EXPECT_TRUE(outcome.converged) << name_of(algorithm) << ", step " << step << ", residual "
                                     << outcome.equilibrium_residual;
      EXPECT_GT(outcome.iterations, 0);
      const auto& u = block.body.displacement();
      all_steps.insert(all_steps.end(), u.begin(), u.end());
    }
    contact_ = block.body.unknowns().contact;
    creep_ = 0.0;
    for (const auto& strain : block.body.problem.inelastic)
      creep_ = std::max(creep_, strain.norm());
    return all_steps;
  }

  void expect_agreement(double floor = 0.0) {
    const auto reference = history(Algorithm::newton, floor);
    const auto contact = contact_;
    EXPECT_GT(creep_, 1e-3) << "creep must matter here";
    EXPECT_NE(std::count(contact.begin(), contact.end(), 0), 0);
    for (Algorithm algorithm : all_algorithms) {
      EXPECT_LE(relative_difference(history(algorithm, floor), reference), 1e-6)
          << name_of(algorithm);
      EXPECT_EQ(contact_, contact) << name_of(algorithm);
    }
  }

  std::vector<char> contact_;
  double creep_ = 0.0;
};
TYPED_TEST_SUITE(AlgorithmsOn, AllFamilies);

/// A converged step leaves for its checks what a new evaluation of its end gives.
TYPED_TEST(AlgorithmsOn, NewtonLeavesTheEvaluationOfItsEnd) {
  typename TestFixture::Block block;
  auto& problem = block.body.problem;
  problem.dt = 0.05;
  auto unknowns = block.at_rest();
  const auto outcome =
      solve_step(problem, options_of(Algorithm::newton), block.body.work, unknowns);
  ASSERT_TRUE(outcome.converged);

  Equilibrium afresh(problem);
  std::vector<double> residual(unknowns.displacement.size());
  const double acting = afresh.residual(unknowns.displacement, residual, return_map_law(problem));
  EXPECT_EQ(block.body.work.residual, residual);
  ASSERT_TRUE(outcome.forces_at_end.has_value());
  EXPECT_EQ(outcome.forces_at_end->acting, acting);
  for (std::size_t i = 0; i < unknowns.deviator.size(); ++i)
    EXPECT_EQ(unknowns.deviator[i].value, afresh.deviator(i).value) << i;
}

TYPED_TEST(AlgorithmsOn, AgreeOnACreepingPartialContact) {
  this->expect_agreement();
}

/// On a floor that comes up towards the ends, which the block leaves and finds again.
TYPED_TEST(AlgorithmsOn, AgreeOnACreepingContactWithAShapedFloor) {
  constexpr double floor = -1e-3;
  EXPECT_GT(relative_difference(this->history(Algorithm::newton),
                                this->history(Algorithm::newton, floor)),
            1e-3)
      << "the floor's shape must matter here";
  this->expect_agreement(floor);
}

/// A step that reaches the iteration limit reports it and keeps its residual history.
TYPED_TEST(AlgorithmsOn, ReportNonConvergenceAsAnOutcome) {
  for (Algorithm algorithm : all_algorithms) {
    typename TestFixture::Block block;
    Options options = options_of(algorithm);
    options.maximum_iterations = 1;
    const auto outcome = block.body.step(options);
    EXPECT_FALSE(outcome.converged) << name_of(algorithm);
    EXPECT_EQ(outcome.iterations, 1) << name_of(algorithm);
    EXPECT_FALSE(outcome.residual_history.empty()) << name_of(algorithm);
    EXPECT_GT(outcome.equilibrium_residual, options.tolerance) << name_of(algorithm);
  }
}

/// A linear system that is not solved ends the step, which the step control repeats with half the
/// time. Conjugate gradients on two grids give up where the solid is as good as incompressible; how
/// nearly, is up to the round-off of the algorithm's own matrix.
TEST(SolidAlgorithms, AStepWhoseLinearSystemIsNotSolvedHasNotConverged) {
  for (const Algorithm algorithm : all_algorithms) {
    bool provoked = false;
    for (const double below_half : {3e-7, 1e-7, 3e-8, 1e-8}) {
      AlgorithmsOn<fem::Q1Hexahedron>::Block block;
      auto& body = block.body;
      body.set_material(1e9, 0.5 - below_half, 3e-36);
      const auto rows = mesh::extrusion_of(body.mesh);
      ASSERT_TRUE(rows);
      body.work.two_grid = std::make_unique<linalg::TwoGrid<3>>();
      body.work.two_grid->analyze(*rows, 8.0);
      const auto outcome = body.step(options_of(algorithm), 0.05);
      EXPECT_FALSE(outcome.converged) << name_of(algorithm);
      if (outcome.iterations > 1 || outcome.gradient_iterations == 0) continue;
      provoked = true;  // factorised, not solved: nothing was evaluated after it
      EXPECT_EQ(outcome.residual_history.size(), algorithm == Algorithm::newton ? 1u : 0u)
          << name_of(algorithm);
    }
    EXPECT_TRUE(provoked) << name_of(algorithm);
  }
}

}  // namespace
}  // namespace dccast::mechanics
