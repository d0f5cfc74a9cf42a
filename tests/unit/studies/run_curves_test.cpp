#include "server/studies/run_curves.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace dccast::studies
