// time.settled: a casting ends once its curl has settled.
#include <gtest/gtest.h>

#include <cmath>

#include "core/results/result_reader.hpp"
#include "core/statistics/curl_trace.hpp"
#include "tests/unit/casting/small_casting.hpp"
#include "tests/unit/casting/stopped_runs.hpp"

namespace dccast::casting {
namespace {

using statistics::CurlTrace;
using testing::expect_equal;
using testing::Recorder;
using testing::run_with_stops;
using testing::small_casting;

TEST(CurlTrace, KeepsAMinuteAndKnowsNoRateBefore) {
  CurlTrace trace;
  for (int i = 0; i <= 100; ++i) {
    EXPECT_EQ(trace.rate().has_value(), i > 60) << i;
    trace.add(i, 1e-5 * i);
  }
  EXPECT_EQ(trace.time.front(), 40.0);
  EXPECT_NEAR(*trace.rate(), 1e-5, 1e-15);
}

TEST(CurlTrace, ACurlThatTurnsHasNotSettled) {
  CurlTrace trace;
  for (int i = 0; i <= 60; ++i) trace.add(i, 1e-5 * std::abs(i - 30));
  EXPECT_NEAR(*trace.rate(), 0.5e-5, 1e-15) << "although it ends where it began";
}

TEST(CurlTrace, BeginsAnewWithoutACurl) {
  CurlTrace trace;
  trace.add(0.0, 1.0);
  trace.add(1.0, std::nan(""));
  EXPECT_TRUE(trace.time.empty());
}

/// A casting of 90 s and 180 mm, whose curl counts as settled as soon as it may.
Case long_casting() {
  Case c = small_casting(mesh::ElementKind::q1);
  c.validity.when_lost = WhenLost::go_on;
  c.schedule.casting_speed = Curve(2e-3);
  c.time.end = 90.0;
  c.time.settled = 1e-3;
  return c;
}

results::StepReport last_of(const Case& c, Recorder& recorder, const std::string& folder) {
  EXPECT_EQ(run(c, {folder, false}, recorder).end, RunEnd::succeeded);
  return recorder.reports.back();
}

TEST(Settled, EndsTheCastingBeforeItsPlan) {
  const TemporaryFolder folder;
  Recorder recorder;
  const auto last = last_of(long_casting(), recorder, folder / "");
  EXPECT_GE(last.time, 50.0) << "100 mm, and a minute from the first curl in the hold";
  EXPECT_LT(last.time, 80.0);
  EXPECT_EQ(last.progress, 1.0);
  EXPECT_EQ(results::ResultReader(folder / "results.h5").history().back().time, last.time);
}

TEST(Settled, WaitsForWhatIsPlanned) {
  const TemporaryFolder folder;
  Case c = long_casting();
  c.schedule.water_flow_factor = {Abscissa::time, {80.0, 85.0}, {1.0, 1.1}};
  Recorder recorder;
  const auto last = last_of(c, recorder, folder / "");
  EXPECT_GE(last.time, 85.0);
  EXPECT_LT(last.time, 90.0);
}

TEST(Settled, NotBelowTheLeastCurlAndLength) {
  const TemporaryFolder folder;
  Case c = long_casting();
  c.schedule.casting_speed = Curve(1e-3);
  Recorder recorder;
  EXPECT_EQ(last_of(c, recorder, folder / "").time, 90.0) << "90 mm";
}

TEST(Settled, CoolsDownFromThere) {
  const TemporaryFolder folder;
  Case c = long_casting();
  c.cooling.top = thermal::Top::insulated;
  c.time.cool_down = 5.0;
  Recorder recorder;
  const auto last = last_of(c, recorder, folder / "");
  EXPECT_GE(last.time, 55.0);
  EXPECT_LT(last.time, 85.0);
  const auto end_of_casting = std::ranges::find_if(
      recorder.reports, [&](const auto& report) { return report.time > last.time - 5.0 + 1e-9; });
  EXPECT_EQ(end_of_casting->cast_length, last.cast_length) << "nothing is poured any more";
}

TEST(Settled, IsTheSameAfterAResumptionBeforeAndAfter) {
  Case c = long_casting();
  c.cooling.top = thermal::Top::insulated;
  c.time.cool_down = 5.0;
  const auto whole = run_with_stops(c, {});
  const auto steps = std::int64_t(whole.reports.size());
  for (const std::int64_t stop : {steps - 20, steps - 2}) {
    SCOPED_TRACE("stopped after step " + std::to_string(stop));
    expect_equal(run_with_stops(c, {stop}), whole);
  }
}

}  // namespace
}  // namespace dccast::casting
