#include "tests/regression/whole_run.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

using regression::largest_difference;
using regression::run;

casting::Case shipped() {
  return support::load_case("start-billet");
}

TEST(StartBillet, EveryStepPassesItsOwnChecks) {
  for (const auto& r : run(shipped())) {
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-4 * r.weight) << "t = " << r.time;
    EXPECT_LE(r.complementarity_error, 1e-6) << "t = " << r.time;
    EXPECT_LE(r.equilibrium_residual, 1e-8) << "t = " << r.time;
  }
}

/// Newton's feasible descent let pairs go and pushed them back for ever where forces were out of
/// balance: steps were cut that need not be, and the smaller the steps the more of them.
TEST(StartBillet, NoStepIsCut) {
  casting::Case c = shipped();
  c.time.step = Curve(Abscissa::time, {-30.0, -0.001, 0.0}, {1.0, 1.0, 0.1});
  c.time.end = 20.0;
  for (const auto& r : run(c)) EXPECT_EQ(r.failed_attempts, 0) << "t = " << r.time;
}

TEST(StartBillet, NewtonAndVnbmAgreeAtEveryMonitorAndStep) {
  casting::Case c = shipped();
  // Newton alone knows the limit of cold metal, and vnbm does not converge with the laws of the
  // mush.
  c.alloy.cold_strength.reset();
  c.alloy.mush.reset();
  c.mechanics.options.tolerance = 1e-9;
  c.time.end = 20.0;
  const auto newton = run(c);
  c.mechanics.options.algorithm = mechanics::Algorithm::vnbm;
  EXPECT_LE(largest_difference(newton, run(c)), 1e-6) << "[m]";
}

TEST(StartBillet, FinalPlaceOfTheRimAndLiftOfTheAxis) {
  const auto last = run(shipped()).back().monitor_displacement;
  EXPECT_NEAR(1e3 * last.at(0)[0], -1.268, 0.005);
  EXPECT_NEAR(1e3 * last.at(0)[1], 1.854, 0.02);
  EXPECT_EQ(last.at(2)[0], 0.0) << "the axis stays on the axis";
  EXPECT_NEAR(1e3 * last.at(2)[1], 0.013, 0.01);
}

}  // namespace
}  // namespace dccast
