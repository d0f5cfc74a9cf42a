#include "client/model/study.hpp"

#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/html/pages.hpp"
#include "client/html/report_parts.hpp"
#include "client/text/study_text.hpp"

namespace dccast::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// Answers of EvaluateStudy and ListJobs for a study.
struct Answer {
  v1::StudyResult result;
  std::vector<v1::Job> jobs;

  Study study() const { return study_of(result, jobs); }
};

/// Adds a run to 4 s whose corner ends at this curl; its centre stays.
void add_run(Answer& answer, int refinement, double corner_m, v1::JobState state = v1::SUCCEEDED) {
  v1::Job& job = answer.jobs.emplace_back();
  job.set_id("job-" + std::to_string(refinement));
  job.set_study("0f2b9a4e-0000-4000-8000-000000000000");
  job.set_state(state);
  v1::StepReport& step = *job.mutable_last_step();
  step.set_time_s(4.0);
  step.set_cast_length_m(4e-3);
  step.set_nodes(100 * refinement);
  for (const auto& [name, curl] : {std::pair("corner", corner_m), std::pair("centre", 0.0)}) {
    v1::MonitorValue& monitor = *step.add_monitors();
    monitor.set_name(name);
    monitor.add_displacement_m(0.0);
    monitor.add_displacement_m(curl);
  }
  if (state == v1::FAILED) job.mutable_failure()->set_message("did not converge");
  v1::StudyRun& run = *answer.result.add_runs();
  run.set_refinement(refinement);
  run.set_job(job.id());
  run.set_state(state);
  run.add_end_curl_m(corner_m);
  run.add_end_curl_m(0.0);
}

Answer empty_answer() {
  Answer answer;
  answer.result.mutable_study()->set_id("0f2b9a4e-0000-4000-8000-000000000000");
  answer.result.mutable_study()->mutable_refinement()->set_levels(3);
  answer.result.add_monitors("corner");
  answer.result.add_monitors("centre");
  return answer;
}

/// A limit that rises evenly to these figures at 4 s.
void add_limit(Answer& answer, double corner_m, double uncertainty_m,
               std::optional<double> order = {}) {
  for (const auto& [name, part] : {std::pair("corner", 1.0), std::pair("centre", 0.0)}) {
    auto& limit = *answer.result.add_limits();
    limit.mutable_curve()->set_monitor(name);
    for (int i = 1; i <= 4; ++i) {
      limit.mutable_curve()->add_time_s(i);
      limit.mutable_curve()->add_cast_length_m(1e-3 * i);
      limit.mutable_curve()->add_curl_m(0.25 * i * part * corner_m);
      limit.mutable_curve()->add_uncertainty_m(0.25 * i * part * uncertainty_m);
    }
    if (order && part > 0.0) limit.set_order(*order);
  }
}

/// Corner at the end: 4.0, 4.4, 4.6 mm; so the limit is 4.8 +- 0.25 mm.
Study clean_study() {
  Answer answer = empty_answer();
  add_run(answer, 1, 4.0e-3);
  add_run(answer, 2, 4.4e-3);
  add_run(answer, 4, 4.6e-3);
  add_limit(answer, 4.8e-3, 0.25e-3, 1.0);
  return answer.study();
}

/// The finest run failed.
Study study_with_a_loss() {
  Answer answer = empty_answer();
  add_run(answer, 1, 4.0e-3);
  add_run(answer, 2, 4.4e-3);
  add_run(answer, 4, 7.0e-3, v1::FAILED);
  add_limit(answer, 4.4e-3, 1.25 * 0.4e-3);
  return answer.study();
}

TEST(Study, ArrangesLevelsAndLimits) {
  const Study study = clean_study();
  ASSERT_EQ(study.levels.size(), 3u);
  EXPECT_EQ(study.levels[0].refinement, 1);
  EXPECT_EQ(study.levels[2].job.id(), "job-4");
  EXPECT_THAT(study.time_s, ElementsAre(1, 2, 3, 4));
  const MonitorStudy& corner = *study.monitor("corner");
  EXPECT_THAT(corner.end_curl_m, ElementsAre(4.0e-3, 4.4e-3, 4.6e-3));
  EXPECT_EQ(*corner.limit.order, 1.0);
  EXPECT_NEAR(corner.limit.value_m[1], 2.4e-3, 1e-12);
  EXPECT_EQ(corner.least_certain(), 3u);
  EXPECT_FALSE(study.monitor("centre")->limit.order);
  EXPECT_EQ(study.monitor("elsewhere"), nullptr);
}

TEST(Study, WhatFailedDoesNotSpoilTheRest) {
  const Study study = study_with_a_loss();
  EXPECT_EQ(study.levels.size(), 3u);
  EXPECT_EQ(study.succeeded().size(), 2u);
  EXPECT_THAT(study.monitor("corner")->end_curl_m, ElementsAre(4.0e-3, 4.4e-3));
  const std::string table = render::study_table(study);
  EXPECT_THAT(table, testing::ContainsRegex("failed  +-  +-\n"));
  EXPECT_THAT(table, HasSubstr("4.400"));
}

TEST(Study, OneRunSaysNothing) {
  Answer answer = empty_answer();
  add_run(answer, 1, 4.0e-3);
  add_run(answer, 2, 4.4e-3, v1::RUNNING);
  EXPECT_TRUE(answer.study().monitors.empty());
  EXPECT_THAT(render::study_table(answer.study()), Not(HasSubstr("limit")));
}

TEST(Study, JobsThatStandForNoLevelAreNamedApart) {
  Answer answer = empty_answer();
  add_run(answer, 1, 4.0e-3);
  v1::Job replaced;
  replaced.set_id("replaced");
  answer.jobs.push_back(replaced);
  v1::StudyRun& waiting = *answer.result.add_runs();
  waiting.set_refinement(2);
  waiting.set_state(v1::QUEUED);
  const Study study = answer.study();

  ASSERT_EQ(study.others.size(), 1u);
  EXPECT_EQ(study.others[0].id(), "replaced");
  ASSERT_EQ(study.levels.size(), 2u);
  EXPECT_EQ(study.levels[1].job.state(), v1::QUEUED);
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
  EXPECT_THAT(page, Not(HasSubstr("has not been measured")));

  const std::string alone =
      render::report_page(study.levels[0].job, result_of(study.levels[0]), {});
  EXPECT_THAT(alone, HasSubstr("has not been measured: <code>dccast convergence"));
  EXPECT_THAT(page, Not(HasSubstr("nan")));
}

TEST(StudyPart, TheReportNamesALevelThatFailed) {
  const Study study = study_with_a_loss();
  const std::string page =
      render::report_page(study.levels[0].job, result_of(study.levels[0]), study);
  EXPECT_THAT(page, HasSubstr("Refinement 4 is left out: job job-4 is failed"));
  EXPECT_THAT(page, HasSubstr("did not converge"));
  EXPECT_THAT(page, HasSubstr("finest 4.40 ± 0.50</small>"));
}

TEST(StudyPart, TheReportOfAnyOtherRunSaysWhichCommandTellsIt) {
  Answer answer = empty_answer();
  add_run(answer, 1, 4.0e-3);
  add_run(answer, 2, 4.4e-3, v1::RUNNING);
  const Study unfinished = answer.study();
  const StudyLevel& alone = unfinished.levels[0];
  EXPECT_THAT(render::report_page(alone.job, result_of(alone), unfinished),
              HasSubstr("dccast convergence --study " + alone.job.study()));
  const std::string page = render::report_page(alone.job, result_of(alone));
  EXPECT_THAT(page, HasSubstr("<code>dccast convergence CASE</code>"));
  EXPECT_THAT(page, Not(HasSubstr("class='band'")));
  EXPECT_THAT(page, Not(HasSubstr("How much of it")));
}

}  // namespace
}  // namespace dccast::client
