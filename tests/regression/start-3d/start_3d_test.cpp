#include <cmath>

#include "tests/regression/whole_run.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

TEST(Start3d, TheFirstTwentySecondsPassTheirChecksAndCurlAsBefore) {
  casting::Case c = support::load_case("start-3d-paper");
  c.time.end = 20.0;
  const auto reports = regression::run(c);
  for (const auto& r : reports) {
    // Relative to the heat that moves, which in the millisecond between two points of the table of
    // steps is hardly more than round-off of what is stored.
    EXPECT_LE(std::abs(r.energy_balance_error), r.time_step > 0.01 ? 1e-10 : 1e-9)
        << "t = " << r.time;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-3 * r.weight) << "t = " << r.time;
    EXPECT_LE(r.complementarity_error, 1e-4) << "t = " << r.time;
    EXPECT_LE(r.equilibrium_residual, 1e-6) << "t = " << r.time;
    EXPECT_EQ(r.failed_attempts, 0) << "t = " << r.time;
  }
  const auto& last = reports.back().monitor_displacement;
  EXPECT_NEAR(1e3 * last.at(0)[2], 8.85, 0.1) << "corner";
  EXPECT_NEAR(1e3 * last.at(1)[2], 8.60, 0.1) << "middle of the narrow face";
  EXPECT_NEAR(1e3 * last.at(2)[2], 1.23, 0.1) << "middle of the wide face";
}

}  // namespace
}  // namespace dccast
