#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "server/studies/study_plan.hpp"

namespace dccast::studies {
namespace {

using testing::ElementsAre;

v1::CreateStudyRequest refinement_of(int levels) {
  v1::CreateStudyRequest request;
  request.mutable_case_()->add_monitor()->set_name("corner");
  request.mutable_refinement()->set_levels(levels);
  return request;
}

/// Steps to 4 s whose corner curls by 1 mm/s times `factor`; the corner is reported from 2 s on.
EvaluatedRun run_with(int refinement, double factor, double lost_s = 0.0) {
  v1::Job job;
  if (lost_s > 0.0) job.mutable_validity_loss()->set_time_s(lost_s);
  std::vector<v1::StepReport> steps;
  for (int i = 1; i <= 4 * refinement; ++i) {
    v1::StepReport& step = steps.emplace_back();
    const double t = static_cast<double>(i) / refinement;
    step.set_time_s(t);
    step.set_cast_length_m(1e-3 * t);
    if (t < 2.0) continue;
    v1::MonitorValue& monitor = *step.add_monitors();
    monitor.set_name("corner");
    monitor.set_curl_m(1e-3 * t * factor);
  }
  EvaluatedRun run;
  run.run.set_refinement(refinement);
  run.run.set_state(v1::SUCCEEDED);
  run.history = run_curves(job, steps);
  return run;
}

TEST(RefinementPlan, DividesTheCase) {
  auto request = refinement_of(3);
  request.mutable_case_()->mutable_mesh()->set_refinement(2);
  const auto plan = study_plan(request);
  ASSERT_EQ(plan->runs(), 3);
  EXPECT_EQ(plan->run(0).key, "2");
  EXPECT_EQ(plan->run(2).key, "8");
  EXPECT_EQ(plan->run(2).description.mesh().refinement(), 8);
  EXPECT_EQ(plan->run(2).name, "refinement 8");
}

TEST(RefinementPlan, FindsTheLimitOfTheLastCoordinate) {
  const auto plan = study_plan(refinement_of(3));
  v1::StudyResult result;
  plan->evaluate({run_with(1, 1.0), run_with(2, 1.1), run_with(4, 1.15)}, result);
  ASSERT_EQ(result.limits_size(), 1);
  const auto& limit = result.limits(0);
  EXPECT_NEAR(limit.order(), 1.0, 1e-9);
  EXPECT_THAT(limit.curve().time_s(), ElementsAre(1, 2, 3, 4));
  EXPECT_TRUE(std::isnan(limit.curve().curl_m(0)));
  EXPECT_NEAR(limit.curve().curl_m(3), 4.8e-3, 1e-12);
  EXPECT_NEAR(limit.curve().uncertainty_m(3), 0.25e-3, 1e-12);
  EXPECT_FALSE(result.has_valid_until_s());
}

TEST(RefinementPlan, OneRunSaysNothingAndALostOneLeavesTheRest) {
  const auto plan = study_plan(refinement_of(3));
  v1::StudyResult one;
  plan->evaluate({run_with(1, 1.0)}, one);
  EXPECT_EQ(one.limits_size(), 0);

  EvaluatedRun failed = run_with(4, 7.0);
  failed.run.set_state(v1::FAILED);
  v1::StudyResult two;
  plan->evaluate({run_with(1, 1.0), run_with(2, 1.1, 3.2), failed}, two);
  ASSERT_EQ(two.limits_size(), 1);
  EXPECT_FALSE(two.limits(0).has_order());
  EXPECT_NEAR(two.limits(0).curve().curl_m(3), 4.4e-3, 1e-12);
  EXPECT_NEAR(two.limits(0).curve().uncertainty_m(3), 1.25 * 0.4e-3, 1e-12);
  EXPECT_EQ(two.valid_until_s(), 3.5);
}

TEST(RefinementPlan, RefusesWhatCannotBeDivided) {
  EXPECT_TRUE(plan_faults(refinement_of(2)).empty());
  EXPECT_EQ(plan_faults(refinement_of(6)).front().permitted(), "2 to 5");
  auto request = refinement_of(2);
  request.mutable_case_()->clear_monitor();
  EXPECT_THAT(plan_faults(request).front().message(), testing::HasSubstr("[[monitor]]"));
}

}  // namespace
}  // namespace dccast::studies
