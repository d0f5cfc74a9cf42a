#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/shipped.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

v1::CreateStudyRequest remedy(const std::string& code) {
  v1::CreateStudyRequest request;
  const auto* const shipped = shipped::find(shipped::case_templates(), "start-2d-thickness");
  EXPECT_TRUE(case_file::read_text(shipped->text, shipped->name, *request.mutable_case_()).ok());
  request.mutable_remedy()->set_job("a job");
  request.mutable_remedy()->add_findings()->set_code(code);
  return request;
}

TEST(RemedyPlan, IsTheCaseAtTwoQualitiesThenDraftsWithOneLeverMoved) {
  const auto plan = study_plan(remedy("thin_shell"));
  ASSERT_EQ(plan->runs(), 8);
  EXPECT_EQ(plan->run(0).description.quality(), v1::DRAFT);
  EXPECT_EQ(plan->run(1).description.quality(), v1::ENGINEERING);
  EXPECT_THAT(plan->run(0).changes, IsEmpty());

  const PlannedRun slower = plan->run(2);
  EXPECT_EQ(slower.name, "cast 10 % slower");
  EXPECT_EQ(slower.description.quality(), v1::DRAFT);
  EXPECT_GT(slower.description.time().end_s(), plan->run(0).description.time().end_s());

  v1::StudyRun run;
  plan->describe(2, run);
  EXPECT_EQ(run.lever_step().steps(), -1);
  EXPECT_TRUE(run.has_mesh_error());
  plan->describe(0, run);
}

TEST(RemedyPlan, OfACaseWithItsOwnMeshIsAtThatMesh) {
  v1::CreateStudyRequest request = remedy("thin_shell");
  v1::Mesh& mesh = *request.mutable_case_()->mutable_mesh();
  mesh.set_columns(10);
  mesh.set_rows(6);
  mesh.set_side_cell_m(0.01);
  mesh.set_bottom_cell_m(0.01);
  mesh.set_growth_cell_m(0.01);
  request.mutable_case_()->mutable_time()->mutable_step_s()->add_value(1.0);
  const auto plan = study_plan(request);
  EXPECT_EQ(plan->runs(), 7);
  EXPECT_EQ(plan->run(1).name, "cast 10 % slower");
}

TEST(RemedyPlan, OfAFindingThatNoLeverInfluencesIsRefused) {
  EXPECT_THAT(plan_faults(remedy("thin_shell")), IsEmpty());
  EXPECT_THAT(plan_faults(remedy("energy_not_conserved")), SizeIs(1));
}

}  // namespace
}  // namespace dccast::studies
