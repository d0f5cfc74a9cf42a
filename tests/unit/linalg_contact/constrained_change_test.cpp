#include <gtest/gtest.h>

#include "core/mechanics/constrained_system.hpp"
#include "tests/unit/linalg_contact/grid_of_springs.hpp"

namespace dccast::mechanics {
namespace {

using linalg::testing::Grid;

/// Direction of a system whose set moves from the grid's own to `held`, by either way.
std::vector<double> direction(const Grid& grid, const std::vector<char>& held,
                              const std::vector<double>& step, bool anew) {
  Workspace work;
  work.resize(grid.pattern, linalg::Geometry::plane);
  work.residual = grid.b;
  ConstrainedSystem system(grid.pattern, work);
  const std::vector<double> none(step.size(), 0.0);
  work.stiffness = grid.values;
  EXPECT_TRUE(system.factorize(anew ? held : grid.held, anew ? step : none));
  EXPECT_TRUE(anew || system.change(held, step));
  EXPECT_TRUE(system.solve(held, step));
  return work.direction;
}

class ConstrainedSystemOn : public ::testing::TestWithParam<int> {};

TEST_P(ConstrainedSystemOn, AChangeIsAFactorizationAnew) {
  // The bottom of the 10 rows is more than a tenth of them, of the 40 rows it is less.
  const Grid grid(GetParam());
  std::vector<char> held = grid.held;
  std::vector<double> step(held.size(), 0.0);
  int moved = 0;
  for (const int u : grid.bottom) {
    char& h = held[std::size_t(u)];
    if (++moved > 5) break;
    h = h != 0 ? 0 : 1;
    if (h != 0) step[std::size_t(u)] = 0.1 * moved;  // a gap to close
  }
  const auto anew = direction(grid, held, step, true), changed = direction(grid, held, step, false);
  for (std::size_t i = 0; i < anew.size(); ++i) EXPECT_NEAR(changed[i], anew[i], 1e-11) << i;
}

INSTANTIATE_TEST_SUITE_P(Sizes, ConstrainedSystemOn, ::testing::Values(10, 40));

TEST(ConstrainedSystem, AStepOfHeldUnknownsCountsOnce) {
  const Grid grid(6);
  Workspace work;
  work.resize(grid.pattern, linalg::Geometry::plane);
  work.residual.assign(grid.b.size(), 0.0);
  ConstrainedSystem system(grid.pattern, work);
  std::vector<double> step(grid.b.size(), 0.0);
  work.stiffness = grid.values;
  ASSERT_TRUE(system.factorize(grid.held, step));

  std::vector<char> held = grid.held;
  held[1] = held[1] != 0 ? 0 : 1;
  step[std::size_t(grid.bottom[1])] = 1.0;
  held[std::size_t(grid.bottom[1])] = 1;
  ASSERT_TRUE(system.change(held, step));
  EXPECT_TRUE(system.solve(held, step));
  EXPECT_EQ(work.direction[std::size_t(grid.bottom[1])], 1.0);
  EXPECT_TRUE(system.solve(held, std::vector<double>(step.size(), 0.0)));

  for (const double d : work.direction) EXPECT_EQ(d, 0.0);
}

}  // namespace
}  // namespace dccast::mechanics
