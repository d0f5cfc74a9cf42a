#include "tests/regression/whole_run.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

/// The metal's own heat leaves the shell over the block whole.
TEST(Start2dLong, IsSoundToItsEnd) {
  const auto [outcome, reports] = regression::outcome_of(support::load_case("start-2d-long"));
  ASSERT_EQ(outcome.end, casting::RunEnd::succeeded) << casting::in_words(outcome.failures);
  EXPECT_NEAR(1e3 * reports.back().monitor_displacement.at(0)[1], 19.76, 0.3);
  for (const auto& r : reports) {
    EXPECT_LE(r.energy_balance_error, 1e-9) << "t = " << r.time;
    EXPECT_FALSE(r.beyond_validity) << "t = " << r.time;
    EXPECT_TRUE(r.time <= 0.0 || r.bottom_shell > 0.015) << "t = " << r.time;
  }
}

/// A level that is held at the casting temperature cuts it through.
TEST(Start2dLong, UnderAHeldLevelItFailsWhereItsShellIsCutThrough) {
  casting::Case c = support::load_case("start-2d-long");
  c.cooling.top = thermal::Top::held;
  c.cooling.water.boiling_follows_flow = false;
  c.alloy.shell = c.alloy.solidus;
  constexpr double shipped_end = 150.0;
  const auto [outcome, reports] = regression::outcome_of(c);
  ASSERT_EQ(outcome.end, casting::RunEnd::failed);
  ASSERT_EQ(outcome.failures.size(), 1u) << casting::in_words(outcome.failures);
  const casting::RunFailure& failure = outcome.failures[0];
  EXPECT_EQ(failure.kind, casting::FailureKind::shell_melted_through) << failure.message;
  EXPECT_NEAR(failure.time, 166.0, 4.0);
  ASSERT_EQ(failure.place.size(), 2u);
  EXPECT_NEAR(failure.place[0], 0.2, 0.1) << "the middle of the half width";
  EXPECT_EQ(failure.place[1], 0.0) << "on the block";
  EXPECT_EQ(reports.back().time, failure.time);
  for (const auto& r : reports) {
    EXPECT_EQ(r.beyond_validity, r.time >= failure.time);
    EXPECT_LE(r.bottom_slip, 5e-3) << "not yet at t = " << r.time;
    if (r.time > shipped_end) continue;
    EXPECT_LE(r.maximum_rotation, 0.1) << "t = " << r.time;
  }
}

}  // namespace
}  // namespace dccast
