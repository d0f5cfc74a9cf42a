#include "server/studies/study_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace dccast::studies {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

v1::CreateStudyRequest sweep_of(v1::SweepPlan::Design design,
                                const std::vector<std::vector<std::string>>& axes, int runs = 0) {
  v1::CreateStudyRequest request;
  request.mutable_case_()->mutable_section()->set_half_width_m(0.25);
  request.mutable_sweep()->set_design(design);
  request.mutable_sweep()->set_runs(runs);
  for (const auto& axis : axes) {
    auto& added = *request.mutable_sweep()->add_axes();
    added.set_key(axis.front());
    for (std::size_t i = 1; i < axis.size(); ++i) added.add_values(axis[i]);
  }
  return request;
}

/// (run, axis)
std::vector<std::vector<std::string>> values_of(const v1::CreateStudyRequest& request) {
  const auto plan = study_plan(request);
  std::vector<std::vector<std::string>> values;
  for (int number = 0; number < plan->runs(); ++number) {
    v1::StudyRun run;
    plan->describe(number, run);
    values.emplace_back(run.values().begin(), run.values().end());
  }
  return values;
}

TEST(SweepPlan, ARunOfManyChangesIsNamedByTheFirst) {
  const auto plan = study_plan(sweep_of(v1::SweepPlan::GRID, {{"mesh.rows", "10"},
                                                              {"mesh.columns", "8"},
                                                              {"mesh.refinement", "2"},
                                                              {"schedule.hold", "50 s"},
                                                              {"time.end", "9 s"},
                                                              {"time.step", "1 s"}}));
  EXPECT_EQ(plan->run(0).name,
            "run 1 (mesh.rows = 10, mesh.columns = 8, mesh.refinement = 2, schedule.hold = 50 s, "
            "2 more)");
}

TEST(SweepPlan, AGridHasEveryValueWithEveryOther) {
  const auto request = sweep_of(
      v1::SweepPlan::GRID,
      {{"schedule.casting_speed", "40 mm/min", "60 mm/min"}, {"mesh.rows", "10", "20", "30"}});
  ASSERT_TRUE(plan_faults(request).empty());

  const auto plan = study_plan(request);
  ASSERT_EQ(plan->runs(), 6);

  const PlannedRun last = plan->run(5), second = plan->run(1);
  EXPECT_EQ(last.description.mesh().rows(), 30);
  EXPECT_EQ(second.description.mesh().rows(), 20);
  EXPECT_DOUBLE_EQ(last.description.schedule().casting_speed_m_per_s().value(0), 1e-3);
  EXPECT_EQ(last.description.section().half_width_m(), 0.25);
  EXPECT_EQ(last.key, "6");
  EXPECT_EQ(last.name, "run 6 (schedule.casting_speed = 60 mm/min, mesh.rows = 30)");

  v1::StudyRun run;
  plan->describe(1, run);
  EXPECT_THAT(run.values(), ElementsAre("40 mm/min", "20"));
  EXPECT_THAT(run.numbers(), ElementsAre(testing::DoubleEq(40e-3 / 60.0), 20.0));
}

/// The error of mesh and steps is known at the built-in meshes of the qualities.
TEST(SweepPlan, EveryRunHasTheErrorOfItsOwnMeshAndSteps) {
  const auto errors = [](const v1::CreateStudyRequest& request) {
    std::vector<double> all;
    const auto plan = study_plan(request);
    for (int number = 0; number < plan->runs(); ++number) {
      v1::StudyRun run;
      plan->describe(number, run);
      all.push_back(run.mesh_error().upper());
    }
    return all;
  };
  const auto speeds =
      errors(sweep_of(v1::SweepPlan::GRID, {{"schedule.casting_speed", "40 mm/min", "60 mm/min"}}));
  EXPECT_GT(speeds[0], 0.0);
  EXPECT_EQ(speeds[1], speeds[0]);

  const auto qualities =
      errors(sweep_of(v1::SweepPlan::LIST, {{"quality", "draft", "engineering"}}));
  EXPECT_GT(qualities[0], qualities[1]);
  EXPECT_GT(qualities[1], 0.0);
  EXPECT_THAT(errors(sweep_of(v1::SweepPlan::LIST, {{"mesh.rows", "10", "20"}})),
              ElementsAre(0.0, 0.0));
}

TEST(SweepPlan, AListTakesValuesTogetherAndTextsHaveNoNumber) {
  const auto request =
      sweep_of(v1::SweepPlan::LIST, {{"alloy.card", "paper", "al6cu"}, {"mesh.rows", "10", "20"}});
  ASSERT_TRUE(plan_faults(request).empty());
  const auto plan = study_plan(request);
  ASSERT_EQ(plan->runs(), 2);
  EXPECT_EQ(plan->run(1).description.alloy().card(), "al6cu");
  EXPECT_EQ(plan->run(1).description.mesh().rows(), 20);
  v1::StudyRun run;
  plan->describe(0, run);
  EXPECT_TRUE(std::isnan(run.numbers(0)));
}

TEST(SweepPlan, ALatinHypercubeHasOnePlaceInEachPartOfEachAxis) {
  const auto request = sweep_of(
      v1::SweepPlan::LATIN_HYPERCUBE,
      {{"schedule.casting_speed", "40 mm/min", "1.5 mm/s"}, {"mesh.rows", "10", "49"}}, 20);
  ASSERT_TRUE(plan_faults(request).empty());

  const auto values = values_of(request);
  ASSERT_EQ(values.size(), 20u);

  std::set<int> parts;
  for (const auto& run : values) {
    const double speed = number_of(request.case_(), "schedule.casting_speed", run[0]);
    EXPECT_GT(speed, 40e-3 / 60.0);
    EXPECT_LT(speed, 1.5e-3);
    parts.insert(static_cast<int>((speed - 40e-3 / 60.0) / (1.5e-3 - 40e-3 / 60.0) * 20));
    EXPECT_THAT(run[0], HasSubstr(" mm/min"));
    EXPECT_EQ(run[1].find('.'), std::string::npos) << run[1];
  }
  EXPECT_EQ(parts.size(), 20u);
  EXPECT_EQ(values_of(request), values);

  auto other = request;
  other.mutable_sweep()->set_seed(7);
  EXPECT_NE(values_of(other), values);
}

TEST(SweepPlan, EndsMoveOneKeyAtATime) {
  auto request = sweep_of(v1::SweepPlan::ENDS,
                          {{"schedule.hold.scale", "0.9", "1.1"}, {"mesh.rows", "10", "30"}});
  request.mutable_case_()->mutable_schedule()->set_hold_s(60.0);
  ASSERT_TRUE(plan_faults(request).empty());

  const auto plan = study_plan(request);
  ASSERT_EQ(plan->runs(), 5);
  EXPECT_EQ(plan->run(0).name, "run 1 (the case itself)");
  EXPECT_TRUE(plan->run(0).changes.empty());
  EXPECT_DOUBLE_EQ(plan->run(2).description.schedule().hold_s(), 66.0);
  EXPECT_FALSE(plan->run(2).description.mesh().has_rows());
  EXPECT_EQ(plan->run(3).name, "run 4 (mesh.rows = 10)");
  EXPECT_DOUBLE_EQ(plan->run(3).description.schedule().hold_s(), 60.0);

  v1::StudyRun run;
  plan->describe(3, run);
  EXPECT_THAT(run.values(), ElementsAre("", "10"));
  EXPECT_TRUE(std::isnan(run.numbers(0)));
}

TEST(SweepPlan, AHypercubeOverFactorsAndDifferencesHasTheirNumbers) {
  auto request = sweep_of(
      v1::SweepPlan::LATIN_HYPERCUBE,
      {{"schedule.hold.scale", "0.9", "1.1"}, {"schedule.hold.offset", "-5 s", "5 s"}}, 10);
  request.mutable_case_()->mutable_schedule()->set_hold_s(60.0);
  ASSERT_TRUE(plan_faults(request).empty());
  EXPECT_DOUBLE_EQ(number_of(request.case_(), "schedule.hold.scale", "90 %"), 0.9);
  EXPECT_DOUBLE_EQ(number_of(request.case_(), "schedule.hold.offset", "-2 s"), -2.0);
}

TEST(SweepPlan, FaultsNameKeyValueAndWhatIsPermitted) {
  const auto first = [](const v1::CreateStudyRequest& request) {
    const auto faults = plan_faults(request);
    return faults.empty() ? std::string("none")
                          : faults.front().field() + ": " + faults.front().message() + ": " +
                                faults.front().permitted();
  };
  EXPECT_THAT(first(sweep_of(v1::SweepPlan::GRID, {})), HasSubstr("sweep.axes"));
  EXPECT_THAT(first(sweep_of(v1::SweepPlan::GRID, {{"mesh.rows"}})), HasSubstr("mesh.rows"));
  EXPECT_THAT(first(sweep_of(v1::SweepPlan::GRID, {{"mesh.rows", "1", "0"}})),
              HasSubstr("mesh.rows"));
  EXPECT_THAT(first(sweep_of(v1::SweepPlan::GRID, {{"mesh.lines", "1"}})), HasSubstr("mesh.lines"));
  EXPECT_THAT(first(sweep_of(v1::SweepPlan::GRID, {{"mesh.rows", "1"}, {"mesh.rows", "2"}})),
              HasSubstr("twice"));
  EXPECT_THAT(
      first(sweep_of(v1::SweepPlan::LIST, {{"mesh.rows", "1"}, {"mesh.columns", "2", "3"}})),
      HasSubstr("mesh.columns"));
  EXPECT_THAT(first(sweep_of(v1::SweepPlan::LATIN_HYPERCUBE, {{"mesh.rows", "30", "10"}}, 5)),
              HasSubstr("is no range"));
  EXPECT_THAT(first(sweep_of(v1::SweepPlan::LATIN_HYPERCUBE, {{"mesh.rows", "10", "30"}}, 0)),
              HasSubstr("1 to 10000"));
  EXPECT_THAT(first(v1::CreateStudyRequest{}), HasSubstr("refinement, sweep"));
}

/// A study that asks for a surface gets as many runs as one needs, or is refused before it
/// computes.
TEST(SweepPlan, FewerRunsThanAnAnswerNeedsAreRefused) {
  auto request = sweep_of(v1::SweepPlan::LATIN_HYPERCUBE,
                          {{"mesh.rows", "10", "30"},
                           {"section.half_width", "0.2 m", "0.3 m"},
                           {"schedule.casting_speed", "40 mm/min", "50 mm/min"}},
                          5);
  EXPECT_TRUE(plan_faults(request).empty()) << "a plain sweep has its table";
  for (const auto purpose : {v1::SweepPlan::UNCERTAINTY, v1::SweepPlan::CALIBRATION}) {
    request.mutable_sweep()->set_purpose(purpose);
    request.mutable_sweep()->set_runs(5);
    const auto faults = plan_faults(request);
    ASSERT_EQ(faults.size(), 1u);
    EXPECT_EQ(faults[0].field(), "sweep.runs");
    EXPECT_EQ(faults[0].value(), "5");
    EXPECT_EQ(faults[0].permitted(), "6 or more");
    request.mutable_sweep()->set_runs(6);
    EXPECT_TRUE(plan_faults(request).empty());
  }
}

/// Only the runs of a grid multiply with its keys.
TEST(SweepPlan, AListTakesMoreKeysThanAGrid) {
  std::vector<std::vector<std::string>> axes;
  for (int i = 0; i < 21; ++i) axes.push_back({"monitor[1].name", "a name"});
  const auto permitted = [&](v1::SweepPlan::Design design) {
    return plan_faults(sweep_of(design, axes)).front().permitted();
  };
  EXPECT_EQ(permitted(v1::SweepPlan::GRID), "1 to 20");
  EXPECT_EQ(permitted(v1::SweepPlan::LIST), "each key once");
}

}  // namespace
}  // namespace dccast::studies
