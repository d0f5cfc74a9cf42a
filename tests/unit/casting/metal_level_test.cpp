// schedule.metal_level: the metal rises and falls in a mould that stays where it is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::Recorder;
using testing::small_casting;

/// The run of a level against cast length, with its frames.
struct Cast {
  explicit Cast(const Curve& level) {
    Case c = small_casting(mesh::ElementKind::q1);
    c.validity.when_lost = WhenLost::go_on;
    c.schedule.metal_level = level;
    EXPECT_EQ(run(c, {folder / "", false}, recorder).end, RunEnd::succeeded);
  }

  const results::StepReport& last() const { return recorder.reports.back(); }
  results::Frame last_frame() const {
    const results::ResultReader reader(folder / "results.h5");
    return reader.frame(reader.frames() - 1);
  }
  double worst_balance() const {
    double worst = 0.0;
    for (const auto& report : recorder.reports)
      worst = std::max(worst, report.energy_balance_error);
    return worst;
  }

  TemporaryFolder folder;
  Recorder recorder;
};

Curve by_length(double end) {
  return {Abscissa::cast_length, {0.0, 0.01}, {0.0, end}};
}

TEST(MetalLevel, IsThatOfTheFramesAndOfTheMesh) {
  for (const double above : {8e-3, -8e-3, -0.01}) {
    const Cast cast(by_length(above));
    const results::Frame frame = cast.last_frame();
    EXPECT_NEAR(frame.metal_level, 0.1 + cast.last().cast_length + above, 1e-12);
    double highest = 0.0;
    for (std::size_t i = 1; i < frame.node.size(); i += 2)
      highest = std::max(highest, frame.node[i]);
    EXPECT_NEAR(highest, frame.metal_level, 1e-12);
    EXPECT_LT(cast.worst_balance(), 1e-10);
  }
}

/// A level of zero is no level: the same bits.
TEST(MetalLevel, OfZeroChangesNoBit) {
  const Cast plain{Curve()}, zero{Curve(0.0)};
  ASSERT_EQ(plain.recorder.reports.size(), zero.recorder.reports.size());
  for (std::size_t i = 0; i < plain.recorder.reports.size(); ++i)
    EXPECT_TRUE(testing::equal_except_timing(plain.recorder.reports[i], zero.recorder.reports[i]));
}

/// 8 mm more metal bring their own heat and weight, and the depth of the sump counts from them.
TEST(MetalLevel, WhatIsPouredOnTopCounts) {
  const Cast plain{Curve()}, higher{by_length(8e-3)}, lower{by_length(-8e-3)};
  EXPECT_GT(higher.last().weight, plain.last().weight);
  EXPECT_LT(lower.last().weight, plain.last().weight);
  EXPECT_NEAR(higher.last().sump_depth, plain.last().sump_depth + 8e-3, 2e-3);
  EXPECT_NEAR(lower.last().sump_depth, plain.last().sump_depth - 8e-3, 2e-3);

  // The water line hangs on the mould: far below the level the slab hardly knows of it.
  EXPECT_NEAR(higher.last().mould_exit_temperature, plain.last().mould_exit_temperature, 3.0);
}

/// A measured level that falls faster than the block leaves the metal where it is.
TEST(MetalLevel, ThatIsMeasuredCannotTakeMetalAway) {
  class Plant : public LeverFeed {
    Arrived wait_until(double) override {
      Arrived arrived;
      for (double t = std::exchange(next_, 40.0); t < 40.0; t += 1.0) {
        LeverReading r{.time = t, .value = {}};
        r.of(Lever::metal_level) = t > 5.0 && t < 8.0 ? -0.02 : 0.0;
        arrived.readings.push_back(r);
      }
      arrived.closed = true;
      return arrived;
    }
    double next_ = -10.0;
  } plant;

  const TemporaryFolder folder;
  Recorder recorder;
  Case c = small_casting(mesh::ElementKind::q1);
  c.validity.when_lost = WhenLost::go_on;
  c.output.frame_interval = 1.0;
  ASSERT_EQ(run(c, {folder / "", false}, recorder, 1, &plant).end, RunEnd::succeeded);

  const results::ResultReader reader(folder / "results.h5");
  double before = 0.0;
  for (std::size_t i = 0; i < reader.frames(); ++i) {
    const results::Frame frame = reader.frame(i);
    EXPECT_GE(frame.metal_level, before);
    before = frame.metal_level;
    if (frame.time >= 8.0 && frame.time < 20.0) {
      EXPECT_NEAR(before, 0.1 + frame.cast_length, 1e-12) << frame.time;
    }
  }
  EXPECT_EQ(reader.levers().of(Lever::metal_level)[16], -0.02);
}

}  // namespace
}  // namespace dccast::casting
