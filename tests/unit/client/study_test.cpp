#include "client/study.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/divided_case.hpp"
#include "client/render/report_page.hpp"
#include "client/render/study_part.hpp"
#include "client/render/study_table.hpp"
#include "proto/case_file/case_file.hpp"

namespace dccast::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A run to 4 s whose corner curls by 1 mm/s times `factor`; its centre stays.
StudyLevel run_with(int refinement, double factor, v1::JobState state = v1::SUCCEEDED) {
  StudyLevel level;
  level.refinement = refinement;
  level.job.set_id("job-" + std::to_string(refinement));
  level.job.set_study("0f2b9a4e-0000-4000-8000-000000000000");
  level.job.set_state(state);
  level.job.mutable_create_time()->set_seconds(1000 + refinement);
  v1::StepReport& step = *level.job.mutable_last_step();
  for (int i = 1; i <= 4 * refinement; ++i) {
    const double t = static_cast<double>(i) / refinement;
    step.Clear();
    step.set_time_s(t);
    step.set_cast_length_m(1e-3 * t);
    step.set_nodes(100 * refinement);
    for (const auto& [name, curl] :
         {std::pair("corner", 1e-3 * t * factor), std::pair("centre", 0.0)}) {
      v1::MonitorValue& monitor = *step.add_monitors();
      monitor.set_name(name);
      monitor.add_displacement_m(0.0);
      monitor.add_displacement_m(curl);
    }
    level.history.add(step);
  }
  if (state == v1::FAILED) level.job.mutable_failure()->set_message("did not converge");
  return level;
}

/// Corner at the end: 4.0, 4.4, 4.6 mm; so the limit is 4.8 +- 0.25 mm.
Study clean_study() {
  return study_of("s", {run_with(4, 1.15), run_with(1, 1.0), run_with(2, 1.1)});
}

TEST(Study, OrdersItsLevelsAndTakesTheInstantsOfTheCoarsest) {
  const Study study = clean_study();
  ASSERT_EQ(study.levels.size(), 3u);
  EXPECT_EQ(study.levels[0].refinement, 1);
  EXPECT_EQ(study.levels[2].refinement, 4);
  EXPECT_THAT(study.time_s, ElementsAre(1, 2, 3, 4));
  const MonitorStudy& corner = *study.monitor("corner");
  EXPECT_THAT(corner.end_curl_m, ElementsAre(4.0e-3, testing::DoubleEq(4.4e-3), 4.6e-3));
  EXPECT_NEAR(*corner.limit.order, 1.0, 1e-9);
  EXPECT_NEAR(corner.limit.value_m[1], 2.4e-3, 1e-12);
  EXPECT_NEAR(corner.limit.value_m[3], 4.8e-3, 1e-12);
  EXPECT_NEAR(corner.limit.uncertainty_m[3], 0.25e-3, 1e-12);
  EXPECT_EQ(corner.least_certain(), 3u);
  EXPECT_EQ(study.monitor("elsewhere"), nullptr);
}

TEST(Study, WhatFailedDoesNotSpoilTheRest) {
  const Study study =
      study_of("s", {run_with(1, 1.0), run_with(2, 1.1), run_with(4, 7.0, v1::FAILED)});
  EXPECT_EQ(study.levels.size(), 3u);
  EXPECT_EQ(study.succeeded().size(), 2u);
  const MonitorStudy& corner = *study.monitor("corner");
  EXPECT_FALSE(corner.limit.order.has_value());
  EXPECT_NEAR(corner.limit.value_m.back(), 4.4e-3, 1e-12);
  EXPECT_NEAR(corner.limit.uncertainty_m.back(), 1.25 * 0.4e-3, 1e-12);
  const std::string table = render::study_table(study);
  EXPECT_THAT(table, testing::ContainsRegex("failed  +-  +-\n"));
  EXPECT_THAT(table, HasSubstr("4.400"));
}

TEST(Study, OneRunSaysNothing) {
  const Study study = study_of("s", {run_with(1, 1.0), run_with(2, 1.1, v1::RUNNING)});
  EXPECT_TRUE(study.monitors.empty());
  EXPECT_THAT(render::study_table(study), Not(HasSubstr("limit")));
}

TEST(Study, OfOneRefinementTheRunThatSucceededCountsThenTheNewer) {
  StudyLevel older = run_with(1, 3.0), newer = run_with(1, 1.0),
             failed = run_with(1, 1.0, v1::FAILED);
  older.job.set_id("older");
  newer.job.mutable_create_time()->set_seconds(2000);
  failed.job.mutable_create_time()->set_seconds(3000);
  const Study study = study_of("s", {older, failed, newer, run_with(2, 1.1)});
  ASSERT_EQ(study.levels.size(), 2u);
  EXPECT_EQ(study.levels[0].job.id(), "job-1");
  EXPECT_EQ(study.others.size(), 2u);
  EXPECT_NEAR(study.monitor("corner")->end_curl_m[0], 4e-3, 1e-12);
}

v1::Case some_case() {
  v1::Case description;
  description.mutable_section()->set_half_width_m(0.28);
  description.add_monitor()->set_name("corner");
  case_file::apply_defaults(description);
  return description;
}

TEST(DividedCase, DividesCellsAndEveryStep) {
  v1::Case description = some_case();
  description.mutable_mesh()->set_refinement(2);
  auto& step = *description.mutable_time()->mutable_step_s();
  step.Clear();
  for (const double value : {0.25, 1.0}) {
    step.add_at(step.at_size());
    step.add_value(value);
  }
  description.mutable_time()->set_minimum_step_s(1e-3);
  const v1::Case fine = divided(description, 4);
  EXPECT_EQ(fine.mesh().refinement(), 8);
  EXPECT_THAT(fine.time().step_s().value(), ElementsAre(0.0625, 0.25));
  EXPECT_THAT(fine.time().step_s().at(), ElementsAre(0, 1));
  EXPECT_DOUBLE_EQ(fine.time().minimum_step_s(), 2.5e-4);
  EXPECT_TRUE(is_refined_case(description, fine));
  EXPECT_TRUE(is_refined_case(fine, description));
}

TEST(DividedCase, IsAnotherCaseWhenAnythingElseDiffers) {
  const v1::Case description = some_case();
  v1::Case other = divided(description, 2);
  other.set_title("another title");
  other.mutable_limits()->set_maximum_nodes(1);
  EXPECT_TRUE(is_refined_case(description, other));
  other.mutable_section()->set_half_width_m(0.29);
  EXPECT_FALSE(is_refined_case(description, other));
  other = divided(description, 2);
  other.mutable_mesh()->set_element(v1::P1);
  EXPECT_EQ(is_refined_case(description, other), description.mesh().element() == v1::P1);
  other = description;
  other.mutable_mesh()->set_refinement(2);  // cells only
  EXPECT_FALSE(is_refined_case(description, other));
}

TEST(DividedCase, SaysWhyACaseCannotBeDivided) {
  v1::Case description = some_case();
  EXPECT_EQ(reason_against_dividing(description), "");
  description.mutable_mesh()->set_file("slab.msh");
  EXPECT_THAT(reason_against_dividing(description), HasSubstr("mesh.file"));
  description = some_case();
  description.mutable_thermal()->set_file("temperatures.h5");
  EXPECT_THAT(reason_against_dividing(description), HasSubstr("thermal.file"));
  description = some_case();
  description.mutable_mechanics()->set_enabled(false);
  EXPECT_THAT(reason_against_dividing(description), HasSubstr("no curl"));
  description = some_case();
  description.clear_monitor();
  EXPECT_THAT(reason_against_dividing(description), HasSubstr("[[monitor]]"));
}

TEST(StudyPart, TheErrorOfARunReachesBeyondTheIntervalOfTheLimit) {
  const auto error = render::curl_error(clean_study(), "corner", 4.0, 4.0e-3);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->limit_m, 4.8e-3, 1e-12);
  EXPECT_NEAR(error->this_run_m, 0.8e-3 + 0.25e-3, 1e-12);
  EXPECT_TRUE(error->extrapolated);
  EXPECT_FALSE(render::curl_error(clean_study(), "corner", 9.0, 4.0e-3));
  EXPECT_FALSE(render::curl_error(clean_study(), "elsewhere", 4.0, 4.0e-3));
  EXPECT_FALSE(render::curl_error(Study{}, "corner", 4.0, 4.0e-3));
}

TEST(StudyPart, TheBandIsTheIntervalOfTheLimit) {
  const render::ChartBand band = render::curl_band(clean_study(), "corner", false);
  EXPECT_THAT(band.x, ElementsAre(1, 2, 3, 4));
  EXPECT_NEAR(band.low[3], 4.55, 1e-9);
  EXPECT_NEAR(band.middle[3], 4.8, 1e-9);
  EXPECT_NEAR(band.high[3], 5.05, 1e-9);
  EXPECT_NEAR(render::curl_band(clean_study(), "corner", true).x[2], 3.0,
              1e-9);  // mm of cast length
}

TEST(StudyPart, AThinnedBandStillHoldsEveryInterval) {
  Study study;
  MonitorStudy monitor{"corner", {}, {}};
  for (int i = 0; i < 1000; ++i) {
    study.time_s.push_back(i);
    monitor.limit.value_m.push_back(0.0);
    monitor.limit.uncertainty_m.push_back(i == 503 ? 7e-3 : 1e-3);
  }
  study.monitors.push_back(monitor);
  const render::ChartBand band = render::curl_band(study, "corner", false);
  EXPECT_LE(band.x.size(), 80u);
  EXPECT_GE(band.x.size(), 40u);
  EXPECT_EQ(band.x.back(), 999.0);
  EXPECT_NEAR(*std::max_element(band.high.begin(), band.high.end()), 7.0, 1e-9);
  EXPECT_NEAR(*std::min_element(band.low.begin(), band.low.end()), -7.0, 1e-9);
}

v1::QueryResultResponse result_of(const StudyLevel& level) {
  v1::QueryResultResponse result;
  *result.add_steps() = level.job.last_step();
  return result;
}

TEST(StudyPart, TheReportOfARunOfAStudyHasItsErrorItsBandAndTheTable) {
  const Study study = clean_study();
  const std::string page =
      render::report_page(study.levels[0].job, result_of(study.levels[0]), study);
  for (const char* const part :
       {"<strong>4.00</strong> mm", "± 1.05 mm", "limit 4.80 ± 0.25</small>", "class='band'",
        "How much of it is discretisation", "1, this run", "<td>4.600</td>", "<td>1.00</td>",
        "<td>4.800</td>", "<td>0.250</td>"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(page, Not(HasSubstr("is not known")));
  EXPECT_THAT(page, Not(HasSubstr("nan")));
}

TEST(StudyPart, TheReportNamesALevelThatFailed) {
  const Study study =
      study_of("s", {run_with(1, 1.0), run_with(2, 1.1), run_with(4, 7.0, v1::FAILED)});
  const std::string page =
      render::report_page(study.levels[0].job, result_of(study.levels[0]), study);
  EXPECT_THAT(page, HasSubstr("Refinement 4 is left out: job job-4 is failed"));
  EXPECT_THAT(page, HasSubstr("did not converge"));
  EXPECT_THAT(page, HasSubstr("finest 4.40 ± 0.50</small>"));
}

TEST(StudyPart, TheReportOfAnyOtherRunSaysWhichCommandTellsIt) {
  StudyLevel alone = run_with(1, 1.0);
  const Study unfinished = study_of("s", {alone, run_with(2, 1.1, v1::RUNNING)});
  EXPECT_THAT(render::report_page(alone.job, result_of(alone), unfinished),
              HasSubstr("dccast convergence --study " + alone.job.study()));
  alone.job.clear_study();
  const std::string page = render::report_page(alone.job, result_of(alone));
  EXPECT_THAT(page, HasSubstr("<code>dccast convergence CASE</code>"));
  EXPECT_THAT(page, Not(HasSubstr("class='band'")));
  EXPECT_THAT(page, Not(HasSubstr("How much of it")));
}

}  // namespace
}  // namespace dccast::client
