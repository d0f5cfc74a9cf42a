#include <gtest/gtest.h>

#include <algorithm>

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

constexpr Algorithm all[] = {Algorithm::newton, Algorithm::vnbm, Algorithm::sbm, Algorithm::nbm};
const char* name_of(Algorithm a) {
  constexpr const char* names[] = {"newton", "vnbm", "sbm", "nbm"};
  return names[static_cast<int>(a)];
}

double relative_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += (a[i] - b[i]) * (a[i] - b[i]), scale += b[i] * b[i];
  }
  return std::sqrt(sum / scale);
}

template <class Element>
class AlgorithmsOn : public ::testing::Test {
protected:
  /// A few steps of a block that creeps, lifts its ends and comes down again.
  /// @param floor  how far the floor lies below the block at a unit distance, squared [1/m]
  std::vector<double> history(Algorithm algorithm, double floor = 0.0) {
    RestingBlock<Element> block(2e-2, 3e-36, 2.5e6);
    if (floor != 0.0) block.shape_floor([floor](double x) { return floor * x * x; });
    auto unknowns = block.at_rest(std::vector<char>(block.pairs(), 1));
    std::vector<double> all_steps;
    for (int step = 0; step < 3; ++step) {
      block.body.problem.dt = 0.05;
      const auto outcome =
          solve_step(block.body.problem, options_of(algorithm), block.body.work, unknowns);
      EXPECT_TRUE(outcome.converged) << name_of(algorithm) << ", step " << step << ", residual "
                                     << outcome.equilibrium_residual;
      EXPECT_GT(outcome.iterations, 0);
      accumulate_viscoplastic_strain(block.body.problem, unknowns.deviator, unknowns.displacement,
                                     block.body.problem.hardened, block.body.problem.inelastic);
      all_steps.insert(all_steps.end(), unknowns.displacement.begin(), unknowns.displacement.end());
    }
    contact_ = unknowns.contact;
    creep_ = 0.0;
    for (const auto& strain : block.body.problem.inelastic)
      creep_ = std::max(creep_, strain.norm());
    return all_steps;
  }

  std::vector<char> contact_;
  double creep_ = 0.0;
};

using Families =
    ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::BendingQuadrilateral,
                     fem::AxisymmetricP1, fem::AxisymmetricQ1, fem::AxisymmetricBending>;
TYPED_TEST_SUITE(AlgorithmsOn, Families);

TYPED_TEST(AlgorithmsOn, AgreeOnACreepingPartialContact) {
  const auto reference = this->history(Algorithm::newton);
  const auto contact = this->contact_;
  EXPECT_GT(this->creep_, 1e-3) << "creep must matter here";
  EXPECT_NE(std::count(contact.begin(), contact.end(), 0), 0);
  for (Algorithm algorithm : all) {
    EXPECT_LE(relative_difference(this->history(algorithm), reference), 1e-6) << name_of(algorithm);
    EXPECT_EQ(this->contact_, contact) << name_of(algorithm);
  }
}

/// On a floor that comes up towards the ends, which the block leaves and finds again.
TYPED_TEST(AlgorithmsOn, AgreeOnACreepingContactWithAShapedFloor) {
  constexpr double floor = -1e-3;
  const auto flat = this->history(Algorithm::newton);
  const auto reference = this->history(Algorithm::newton, floor);
  const auto contact = this->contact_;
  EXPECT_GT(relative_difference(flat, reference), 1e-3) << "the floor's shape must matter here";
  EXPECT_NE(std::count(contact.begin(), contact.end(), 0), 0);
  for (Algorithm algorithm : all) {
    EXPECT_LE(relative_difference(this->history(algorithm, floor), reference), 1e-6)
        << name_of(algorithm);
    EXPECT_EQ(this->contact_, contact) << name_of(algorithm);
  }
}

/// A step that reaches the iteration limit reports it and keeps its residual history.
TYPED_TEST(AlgorithmsOn, ReportNonConvergenceAsAnOutcome) {
  for (Algorithm algorithm : all) {
    RestingBlock<TypeParam> block(2e-2, 3e-36, 2.5e6);
    Options options = options_of(algorithm);
    options.maximum_iterations = 1;
    auto unknowns = block.at_rest(std::vector<char>(block.pairs(), 1));
    const auto outcome = solve_step(block.body.problem, options, block.body.work, unknowns);
    EXPECT_FALSE(outcome.converged) << name_of(algorithm);
    EXPECT_EQ(outcome.iterations, 1) << name_of(algorithm);
    EXPECT_FALSE(outcome.residual_history.empty()) << name_of(algorithm);
    EXPECT_GT(outcome.equilibrium_residual, options.tolerance) << name_of(algorithm);
  }
}

}  // namespace
}  // namespace dccast::mechanics
