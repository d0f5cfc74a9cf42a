#include "server/studies/run_curves.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/studies/run_results.hpp"

namespace dccast::studies {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::IsNan;

v1::StepReport step(double time_s) {
  v1::StepReport report;
  report.set_step(static_cast<std::int64_t>(time_s));
  report.set_time_s(time_s);
  return report;
}

v1::MonitorValue& add_monitor(v1::StepReport& step, const std::string& name) {
  v1::MonitorValue& monitor = *step.add_monitors();
  monitor.set_name(name);
  return monitor;
}

TEST(RunCurves, AStepWithoutAMonitorHasNaN) {
  std::vector<v1::StepReport> steps{step(1.0), step(2.0), step(3.0)};
  add_monitor(steps[1], "lip").set_curl_m(5e-3);
  add_monitor(steps[2], "gauge").set_temperature_c(300.0);

  const RunCurves history = run_curves({}, steps);
  ASSERT_NE(history.curve("lip"), nullptr);
  EXPECT_THAT(history.curve("lip")->time_s(), ElementsAre(1.0, 2.0, 3.0));
  EXPECT_THAT(history.curve("lip")->curl_m(), ElementsAre(IsNan(), DoubleEq(5e-3), IsNan()));
  EXPECT_THAT(history.temperature_c.at("gauge"), ElementsAre(IsNan(), IsNan(), DoubleEq(300.0)));
  EXPECT_EQ(history.curve("block"), nullptr);
}

TEST(RunCurves, IsBeyondTheModelFromTheFirstStepThatSaysSo) {
  std::vector<v1::StepReport> steps{step(1.0), step(2.0), step(3.0)};
  EXPECT_FALSE(run_curves({}, steps).beyond_from_s);

  steps[2].set_beyond_validity(true);
  EXPECT_EQ(run_curves({}, steps).beyond_from_s, 3.0);

  v1::Job job;
  job.mutable_validity_loss()->set_time_s(1.5);
  EXPECT_EQ(run_curves(job, steps).beyond_from_s, 2.0);
}

/// A run of a casting at 1 mm/s, with a step each 10 s.
EvaluatedRun cast_for(double end_s, double curl_m) {
  std::vector<v1::StepReport> steps;
  for (double t = 10.0; t <= end_s; t += 10.0) {
    steps.push_back(step(t));
    steps.back().set_cast_length_m(1e-3 * t);
    add_monitor(steps.back(), "corner").set_curl_m(curl_m * t / end_s);
  }
  EvaluatedRun run;
  run.run.set_state(v1::SUCCEEDED);
  run.history = run_curves({}, steps);
  return run;
}

TEST(HoldSettled, CurlsStayUpToTheEndOfTheLongestCasting) {
  v1::Case description;
  description.mutable_time()->set_settled_m_per_s(5e-6);
  std::vector<EvaluatedRun> runs{cast_for(40.0, 4e-3), cast_for(70.0, 7e-3)};
  hold_settled(description, runs);

  const v1::CurlCurve& held = *runs[0].history.curve("corner");
  ASSERT_EQ(held.time_s_size(), 5);
  EXPECT_DOUBLE_EQ(held.time_s(4), 70.0);
  EXPECT_NEAR(held.cast_length_m(4), 0.07, 1e-12);
  EXPECT_DOUBLE_EQ(held.curl_m(4), 4e-3);
  EXPECT_EQ(runs[0].history.least_shell_m.size(), 5u);
  EXPECT_EQ(runs[1].history.curve("corner")->time_s_size(), 7) << "the longest stays as it is";
}

TEST(HoldSettled, LeavesOtherCastingsAsTheyAre) {
  v1::Case by_time, cools;
  cools.mutable_time()->set_settled_m_per_s(5e-6);
  cools.mutable_time()->set_cool_down_s(100.0);
  for (const v1::Case& description : {by_time, cools}) {
    std::vector<EvaluatedRun> runs{cast_for(40.0, 4e-3), cast_for(70.0, 7e-3)};
    hold_settled(description, runs);
    EXPECT_EQ(runs[0].history.curve("corner")->time_s_size(), 4);
  }
}

}  // namespace
}  // namespace dccast::studies
