#include "proto/figures/run_history.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dccast::figures {
namespace {

using testing::ElementsAre;

v1::StepReport step_of(int number) {
  v1::StepReport step;
  step.set_step(number);
  step.set_time_s(0.5 * number);
  v1::MonitorValue& monitor = *step.add_monitors();
  monitor.set_name("corner");
  monitor.set_curl_m(1e-3 * number);
  return step;
}

TEST(RunHistory, AStepReportedAgainTakesBackItselfAndAllLaterOnes) {
  RunHistory history;
  for (const int number : {1, 2, 3, 4, 2, 3}) history.add(step_of(number));
  EXPECT_THAT(history.time_s(), ElementsAre(0.5, 1.0, 1.5));
  EXPECT_THAT(history.curl_m("corner"), ElementsAre(1e-3, 2e-3, 3e-3));
}

TEST(RunHistory, RewindsToAStepOrToItsBegin) {
  RunHistory history;
  for (const int number : {1, 2, 3}) history.add(step_of(number));
  history.rewind(2);
  EXPECT_THAT(history.time_s(), ElementsAre(0.5, 1.0));
  history.rewind(0);
  EXPECT_TRUE(history.steps.empty());
}

TEST(RunHistory, IsMarkedFromTheLossOfValidityOn) {
  v1::Job job;
  job.mutable_validity_loss()->set_time_s(1.0);
  const RunHistory history = run_history(job, {step_of(1), step_of(2), step_of(3)});
  EXPECT_THAT(history.beyond(), ElementsAre(false, true, true));
  EXPECT_EQ(history.beyond_from_s(), 1.0);
}

TEST(RunHistory, AMonitorThatIsNotReportedIsUnknown) {
  RunHistory history;
  for (const int number : {1, 2}) history.add(step_of(number));
  history.steps[0].clear_monitors();
  EXPECT_TRUE(std::isnan(history.curl_m("corner")[0]));
  EXPECT_EQ(history.curl_m("corner")[1], 2e-3);
  EXPECT_TRUE(history.curl_m("centre").empty());
}

TEST(MonitorSeries, HorizontalHasTheComponentsOfItsDimension) {
  RunHistory history;
  for (const int number : {1, 2}) history.add(step_of(number));
  for (const double u : {3e-3, -4e-3, 20e-3})
    history.steps[1].mutable_monitors(0)->add_displacement_m(u);

  const MonitorSeries series = history.series("corner");
  EXPECT_THAT(series.horizontal_m[0], testing::SizeIs(2)) << "unknown, of the same dimension";
  EXPECT_THAT(series.horizontal_m[1], ElementsAre(3e-3, -4e-3));
}

TEST(MonitorSeries, HasTemperaturesAndErrorsWhereTheyAreKnown) {
  RunHistory history;
  for (const int number : {1, 2}) history.add(step_of(number));
  v1::MonitorValue& last = *history.steps[1].mutable_monitors(0);
  last.set_temperature_c(603.0);
  last.set_curl_lower_error_m(1e-4);
  last.set_curl_upper_error_m(2e-4);

  const MonitorSeries series = history.series("corner");
  EXPECT_TRUE(std::isnan(series.temperature_c[0]));
  EXPECT_EQ(series.temperature_c[1], 603.0);
  EXPECT_TRUE(std::isnan(series.upper_error_m[0]));
  EXPECT_EQ(series.upper_error_m[1], 2e-4);
  EXPECT_TRUE(series.has_error());
}

TEST(JudgedCurl, IsTheOneThatIsMarked) {
  v1::StepReport step = step_of(1);
  EXPECT_EQ(judged_curl(step), nullptr);
  step.add_monitors()->set_judged(true);
  EXPECT_EQ(judged_curl(step), &step.monitors(1));
  EXPECT_EQ(judged_curl(v1::StepReport()), nullptr);
}

}  // namespace
}  // namespace dccast::figures
