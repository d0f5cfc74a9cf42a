#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/studies/study_plan.hpp"

namespace dccast::studies {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr double length = 0.66, wanted = 0.285;

v1::CreateStudyRequest mould_study() {
  v1::CreateStudyRequest request;
  v1::Section& section = *request.mutable_case_()->mutable_section();
  section.set_kind(v1::Section::QUARTER_SLAB);
  section.set_half_width_m(length);
  section.set_initial_depth_m(0.066);
  section.mutable_half_thickness_m()->set_abscissa(v1::DISTANCE);
  for (const auto& [at, value] : {std::pair(0.0, 0.300), std::pair(length, 0.291)}) {
    section.mutable_half_thickness_m()->add_at(at);
    section.mutable_half_thickness_m()->add_value(value);
  }
  for (const auto& [x, y] :
       {std::pair(length, 0.291), std::pair(0.0, 0.300), std::pair(0.0, 0.1)}) {
    v1::Monitor& monitor = *request.mutable_case_()->add_monitor();
    monitor.set_x_m(x);
    monitor.set_y_m(y);
  }
  request.mutable_mould()->set_tolerance_m(0.5e-3);
  request.mutable_mould()->set_wanted_half_thickness_m(wanted);
  return request;
}

/// A run whose cold slab is narrower than its mould by 19 mm in the middle and 6 mm at the end.
EvaluatedRun cast_in(const v1::Case& description) {
  EvaluatedRun run;
  run.run.set_state(v1::SUCCEEDED);
  run.face.emplace(RunFace{description.section(), {}});
  constexpr int nodes = 12;
  for (int i = 0; i < nodes; ++i) {
    const double x = length * i / (nodes - 1), share = x / length;
    run.face->steady.x_m.push_back(x);
    run.face->steady.mould_m.push_back(frames::half_opening_m(description.section(), x));
    run.face->steady.cold_m.push_back(run.face->steady.mould_m.back() - 0.019 +
                                      0.013 * share * share);
  }
  return run;
}

std::string fields_of(const v1::CreateStudyRequest& request) {
  std::string fields;
  for (const v1::Fault& fault : plan_faults(request)) {
    fields += fault.field() + " ";
    EXPECT_FALSE(fault.message().empty() || fault.permitted().empty() || fault.remedy().empty());
  }
  return fields;
}

TEST(MouldPlan, BeginsInTheMouldOfTheCaseAndGrows) {
  const auto plan = study_plan(mould_study());
  EXPECT_EQ(plan->runs(), 1);
  EXPECT_EQ(plan->most_runs(), 12);
  EXPECT_TRUE(plan->grows());
  const PlannedRun first = plan->run(0);
  EXPECT_THAT(first.changes, IsEmpty());
  EXPECT_EQ(first.description.section().half_thickness_m().value(1), 0.291);
  EXPECT_EQ(first.key, plan->key(0));
}

TEST(MouldPlan, TheNextRunCorrectsTheOpeningAndTakesTheMonitorsOfTheFaceAlong) {
  const auto plan = study_plan(mould_study());
  const auto next = plan->next(1, {cast_in(plan->run(0).description)});
  ASSERT_TRUE(next);
  EXPECT_EQ(next->key, plan->key(1));
  EXPECT_EQ(next->name, "run 2");

  const v1::Curve& opening = next->description.section().half_thickness_m();
  ASSERT_EQ(opening.value_size(), 4);
  EXPECT_NEAR(opening.value(0), wanted + 0.019, 1e-3);
  EXPECT_NEAR(opening.value(3), wanted + 0.006, 1e-3);
  EXPECT_NEAR(opening.at(3), length, 1e-12);
  EXPECT_EQ(next->description.monitor(0).y_m(), opening.value(3));
  EXPECT_EQ(next->description.monitor(1).y_m(), opening.value(0));
  EXPECT_EQ(next->description.monitor(2).y_m(), 0.1) << "inside";
  EXPECT_EQ(next->changes.front().key(), "section.half_thickness");
  EXPECT_THAT(next->changes.front().value(), HasSubstr("[\"660 mm\""));
}

TEST(MouldPlan, ARoundedCornerStaysAndItsMonitorGoesWithTheOpening) {
  auto request = mould_study();
  request.mutable_case_()->mutable_section()->set_corner_radius_m(0.06);
  request.mutable_case_()->mutable_monitor(0)->set_y_m(0.26);
  const auto plan = study_plan(request);
  const auto next = plan->next(1, {cast_in(plan->run(0).description)});
  ASSERT_TRUE(next);
  const v1::Section& section = next->description.section();
  EXPECT_EQ(section.corner_radius_m(), 0.06);
  EXPECT_NEAR(next->description.monitor(0).y_m(),
              0.26 + section.half_thickness_m().value(3) - 0.291, 1e-9);
}

TEST(MouldPlan, EndsWithinTheToleranceAndTellsTheBestRun) {
  const auto plan = study_plan(mould_study());
  std::vector<EvaluatedRun> runs{cast_in(plan->run(0).description)};
  runs.push_back(cast_in(plan->next(1, runs)->description));
  EXPECT_FALSE(plan->next(2, runs));

  v1::StudyResult result;
  plan->evaluate(runs, result);
  EXPECT_TRUE(result.mould().within_tolerance());
  EXPECT_LE(result.mould().residual_m(), 0.5e-3);
  EXPECT_DOUBLE_EQ(result.mould().wanted_half_thickness_m(), wanted);
  EXPECT_TRUE(result.mould().is_steady());
  EXPECT_EQ(result.mould().x_m_size(), 4);
  EXPECT_EQ(result.mould().half_opening_m_size(), 4);
  EXPECT_EQ(result.mould().profile_m_size(), 12);

  runs.pop_back();
  v1::StudyResult first_only;
  plan->evaluate(runs, first_only);
  EXPECT_FALSE(first_only.mould().within_tolerance());

  v1::StudyResult nothing;
  plan->evaluate({EvaluatedRun{}}, nothing);
  EXPECT_FALSE(nothing.has_mould());
}

TEST(MouldPlan, WithoutAWantedThicknessTheMouldsNarrowEndIsTaken) {
  auto request = mould_study();
  request.mutable_mould()->clear_wanted_half_thickness_m();
  const auto plan = study_plan(request);
  const auto next = plan->next(1, {cast_in(plan->run(0).description)});
  ASSERT_TRUE(next);
  EXPECT_NEAR(next->description.section().half_thickness_m().value(3), 0.291 + 0.006, 1e-3);
}

TEST(MouldPlan, RefusesWhatHasNoMouldToDesign) {
  EXPECT_EQ(fields_of(mould_study()), "");

  auto request = mould_study();
  request.mutable_mould()->set_tolerance_m(0.0);
  request.mutable_mould()->set_maximum_runs(1);
  request.mutable_mould()->set_wanted_half_thickness_m(-1.0);
  EXPECT_EQ(fields_of(request), "mould.tolerance mould.maximum_runs mould.wanted_half_thickness ");

  request = mould_study();
  request.mutable_case_()->mutable_section()->set_kind(v1::Section::PLANE_STRAIN);
  EXPECT_EQ(fields_of(request), "section.kind ");

  request = mould_study();
  request.mutable_case_()->mutable_section()->clear_half_thickness_m();
  EXPECT_EQ(fields_of(request), "section.half_thickness ");

  request = mould_study();
  request.mutable_case_()->mutable_mesh()->set_growth(false);
  request.mutable_case_()->mutable_mesh()->set_file("slab.msh");
  request.mutable_case_()->mutable_mechanics()->set_enabled(false);
  EXPECT_EQ(fields_of(request), "mesh.file mesh.growth mechanics.enabled ");
}

}  // namespace
}  // namespace dccast::studies
