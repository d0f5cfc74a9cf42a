// A team of threads computes the same bits as one thread.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "core/base/team.hpp"
#include "core/linalg/band_cholesky.hpp"
#include "core/linalg/sparsity_pattern.hpp"
#include "tests/support/brick_matrix.hpp"

namespace dccast::linalg {
namespace {

using support::BrickMatrix;

/// A slab on its block, large enough for its factor to be streamed from memory.
class WithATeam : public ::testing::TestWithParam<int> {
protected:
  WithATeam() : brick_({11, 7}, 15), held_(brick_.supports(3)) {
    values_ = brick_.stiffness(
        0.3, [](int i, int j, int k) { return k > 1 && i < 9 && j < 5 ? 5e4 : 5e10; });
    support::decouple(brick_.pattern, held_, values_);
    for (std::size_t u = 0; u < held_.size(); ++u) b_.push_back(std::cos(0.1 * double(u * u)));
  }

  /// Solutions after a factorisation of all rows and after one of the last rows.
  std::array<std::vector<double>, 2> solutions(const TileKernels& kernels) {
    BandCholesky band(kernels);
    band.analyze(brick_.pattern, reversed_order(brick_.unknowns()));
    std::vector<double> values = values_;
    std::array<std::vector<double>, 2> found{b_, b_};
    for (auto& x : found) {
      EXPECT_TRUE(band.factorize(values));
      band.solve(x, x);
      values[0] *= 2.0;  // of the unknown that is eliminated last
    }
    EXPECT_LT(band.share_computed(), 0.01);
    return found;
  }

  BrickMatrix brick_;
  std::vector<char> held_;
  std::vector<double> values_, b_;
};

TEST_P(WithATeam, FactorAndSolutionAreThoseOfOneThread) {
  const TileKernelList kernels = runnable_tile_kernels();
  for (int k = 0; k < kernels.count; ++k) {
    const auto alone = solutions(*kernels.kernel[k]);
    Team team(GetParam());
    const Team::Lent lent(&team);
    for (int repeat = 0; repeat < 2; ++repeat) EXPECT_EQ(solutions(*kernels.kernel[k]), alone);
  }
}

TEST_P(WithATeam, AMatrixThatIsNotPositiveDefiniteEndsForAll) {
  Team team(GetParam());
  const Team::Lent lent(&team);
  BandCholesky band;
  band.analyze(brick_.pattern, reversed_order(brick_.unknowns()));
  for (const int bad : {brick_.unknowns() - 1, 2000, 1999, 1990, 0}) {
    std::vector<double> values = values_;
    values[std::size_t(brick_.pattern.diagonal(bad))] = -1.0;
    EXPECT_FALSE(band.factorize(values)) << bad;
    EXPECT_TRUE(band.factorize(values_));
  }
}

TEST_P(WithATeam, ProductsAreThoseOfOneThread) {
  ASSERT_GT(brick_.pattern.parts().size(), 4u);
  std::vector<double> alone(b_.size()), found(b_.size());
  multiply(brick_.pattern, values_, b_, alone);
  Team team(GetParam());
  const Team::Lent lent(&team);
  for (int repeat = 0; repeat < 20; ++repeat) {
    multiply(brick_.pattern, values_, b_, found);
    ASSERT_EQ(found, alone);
  }
}

INSTANTIATE_TEST_SUITE_P(Members, WithATeam, ::testing::Values(2, 3));

TEST(ProductParts, OfAnExtendedPatternAreThoseOfOneMadeAtOnce) {
  const BrickMatrix small({11, 7}, 5), large({11, 7}, 15);
  SparsityPattern grown = small.pattern;
  grown.extend(large.unknowns(), large.cell_unknowns());
  EXPECT_EQ(grown.parts(), large.pattern.parts());
}

TEST(ProductParts, AreOneWhereTheNumberingIsNotAlongADirection) {
  // Every node is a neighbour of the last one.
  std::vector<int> unknown;
  constexpr int nodes = 12000;
  for (int n = 0; n + 1 < nodes; ++n)
    for (const int node : {n, nodes - 1})
      for (int d = 0; d < 3; ++d) unknown.push_back(3 * node + d);
  const SparsityPattern pattern(3 * nodes, unknown, 6);
  EXPECT_EQ(pattern.parts(), (std::vector<int>{0, 3 * nodes}));
}

}  // namespace
}  // namespace dccast::linalg
