#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/text/study_text.hpp"
#include "client/text/sweep_csv.hpp"
#include "proto/case_file/quality.hpp"
#include "tests/support/study_result.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;

using support::add_axis, support::add_run;

TEST(StudyState, AStudyWhoseRunsFailedInPartHasAnswered) {
  v1::Study study;
  study.set_state(v1::STUDY_FAILED);
  study.set_failed(11);
  EXPECT_EQ(state_text(study), "no answer");
  study.set_succeeded(3);
  EXPECT_EQ(state_text(study), "answered");
  study.set_state(v1::STUDY_CANCELLED);
  EXPECT_EQ(state_text(study), "cancelled");
}

TEST(Sweep, CsvHasTheErrorOfMeshAndStepsWhereItIsKnown) {
  v1::StudyResult result;
  result.add_monitors("corner");
  add_axis(result, "mesh.rows", "10", "20");
  add_run(result, 0, 0, -40.0).mutable_mesh_error()->set_upper(0.05);
  add_run(result, 0, 1, 41.0);
  for (v1::StudyRun& run : *result.mutable_runs()) {
    run.mutable_end_curl_m()->Truncate(1);
    case_file::set_end_errors(v1::Case(), run.end_curl_m(), run);
    run.add_numbers(10.0);
  }
  const std::string csv = sweep_csv(result);
  EXPECT_THAT(csv, HasSubstr("corner_end_curl_m,corner_lower_error_m,corner_upper_error_m,"));
  EXPECT_THAT(csv, HasSubstr(",-0.04,0.002,0,"));
  EXPECT_THAT(csv, HasSubstr(",0.041,,,"));
}

}  // namespace
}  // namespace dccast::client
