#include "dccast/v1/case.pb.h"
#include "tests/regression/start-3d/sound_casting.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

using regression::end_lift_mm;

/// One run, some seconds: its balances and its curl are looked at together.
TEST(Start3dDraft, StaysInBalanceUntilItsCurlHasSettled) {
  const auto reports = regression::run(support::load_case("start-3d", v1::DRAFT));
  regression::expect_sound_casting(reports);
  EXPECT_NEAR(reports.back().time, 840.0, 60.0) << "not at time.end, 1200 s";
  EXPECT_NEAR(end_lift_mm(reports, 0), 53.7, 0.7) << "corner";
  EXPECT_NEAR(end_lift_mm(reports, 1), 51.5, 0.7) << "middle of the narrow face";
  EXPECT_NEAR(end_lift_mm(reports, 2), 4.38, 0.2) << "middle of the wide face";
  EXPECT_NEAR(end_lift_mm(reports, 3), 0.0, 1e-3) << "the centre stands on the block";
  EXPECT_NEAR(end_lift_mm(reports, 4),
              (2.0 * end_lift_mm(reports, 0) + end_lift_mm(reports, 1)) / 3.0, 1e-9)
      << "as plants state it";
}

/// The same with the mush of the paper and a stress-free hold.
TEST(Start3dDraft, WithTheMushOfThePaperStaysInBalanceAndLiftsItsCorner) {
  const auto reports = regression::run(support::load_case("start-3d-paper", v1::DRAFT));
  regression::expect_sound_casting(reports);
  EXPECT_NEAR(end_lift_mm(reports, 0), 36.72, 0.5) << "corner";
  EXPECT_NEAR(end_lift_mm(reports, 1), 35.35, 0.5) << "middle of the narrow face";
  EXPECT_NEAR(end_lift_mm(reports, 2), 5.99, 0.2) << "middle of the wide face";
  EXPECT_NEAR(end_lift_mm(reports, 3), 0.0, 1e-3) << "the centre stands on the block";
}

/// Rows below the quench hold little that changes: merged or not, the slab curls alike.
TEST(Start3dDraft, CurlsAlikeWithRowsMergedOrNot) {
  casting::Case c = support::load_case("start-3d", v1::DRAFT);
  c.section.merging.below = 0.08;
  c.time.end = 150.0;
  const auto merged = regression::run(c);
  c.section.merging = {};
  const auto whole = regression::run(c);
  EXPECT_LT(merged.back().nodes, whole.back().nodes);
  for (std::size_t monitor = 0; monitor < 3; ++monitor)
    EXPECT_NEAR(end_lift_mm(merged, monitor), end_lift_mm(whole, monitor),
                2e-3 * end_lift_mm(whole, 0));
}

double corner_after_five_seconds(mechanics::Algorithm algorithm) {
  casting::Case c = support::load_case("start-3d-paper", v1::DRAFT);
  c.mechanics.options.algorithm = algorithm;
  c.mechanics.options.tolerance = 3e-6;  // of the forces that act, a thousand times the weight
  c.time.end = 5.0;
  return end_lift_mm(regression::run(c), 0);
}

/// While the slab rocks from one support to another what a tolerance leaves is seen in the lift.
TEST(Start3dDraft, LiftsItsCornerByEveryAlgorithm) {
  const double newton = corner_after_five_seconds(mechanics::Algorithm::newton);
  EXPECT_NEAR(newton, 1.275, 0.02);
  EXPECT_NEAR(corner_after_five_seconds(mechanics::Algorithm::vnbm), newton, 0.01);
  EXPECT_NEAR(corner_after_five_seconds(mechanics::Algorithm::nbm), newton, 0.01);
  EXPECT_NEAR(corner_after_five_seconds(mechanics::Algorithm::sbm), newton, 0.05);
}

}  // namespace
}  // namespace dccast
