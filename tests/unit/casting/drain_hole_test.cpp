// Castings over a block with drain holes, whose gap is open from the beginning.
#include <gtest/gtest.h>

#include <cmath>

#include "core/casting/slab_run.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"
#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::casting {
namespace {

using testing::Recorder;

/// Water meets the butt at once and runs into a gap that widens towards the narrow face.
Case quarter_over(std::vector<thermal::DrainHole> holes) {
  Case c = testing::small_quarter_slab();
  c.cooling.water.start = -3.0;
  c.cooling.water.from = 0.03;
  c.cooling.water.boiling_follows_flow = true;
  c.cooling.water.wetting = thermal::testing::wetting();
  c.cooling.bottom_block.wet_coefficient.reset();
  c.cooling.bottom_block.gap_water = thermal::GapWater{0.5, 0.6, 2000.0, 0.3};
  c.cooling.bottom_block.wet_gap = 1e-3;
  c.cooling.bottom_block.profile_x = {Abscissa::distance, {0.0, 0.05, 0.28}, {0.0, 2e-3, 6e-3}};
  c.cooling.bottom_block.drain_holes = std::move(holes);
  return c;
}

std::vector<results::StepReport> run_all(const Case& c) {
  const TemporaryFolder folder;
  Recorder recorder;
  EXPECT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);
  const auto outcome = run(c, {folder / "", false}, recorder);
  EXPECT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  return recorder.reports;
}

/// Heat in equals heat out, the water takes no more than it can, and behind the holes it takes
/// less.
TEST(DrainHoles, KeepTheBalanceOfACasting) {
  const auto closed = run_all(quarter_over({}));
  const auto drained = run_all(quarter_over({{0.2, 0.0, 0.05}, {0.2, 0.1, 0.05}}));
  ASSERT_EQ(closed.size(), drained.size());

  for (const results::StepReport& r : drained) {
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    EXPECT_LE(r.gap_water_share, 1.0);
  }
  EXPECT_GT(drained.back().gap_water_share, 0.0);
  EXPECT_LT(drained.back().gap_water_share, closed.back().gap_water_share);
}

/// A hole under metal that stands on the block changes nothing, to the last bit.
TEST(DrainHoles, ChangeNothingUnderMetalOnTheBlock) {
  const auto closed = run_all(quarter_over({}));
  const auto covered = run_all(quarter_over({{0.0, 0.0, 0.02}}));
  ASSERT_EQ(closed.size(), covered.size());
  for (std::size_t i = 0; i < closed.size(); ++i) {
    EXPECT_EQ(covered[i].bottom_heat, closed[i].bottom_heat);
    EXPECT_EQ(covered[i].gap_water_share, closed[i].gap_water_share);
  }
}

}  // namespace
}  // namespace dccast::casting
