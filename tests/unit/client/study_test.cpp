#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "client/html/pages.hpp"
#include "server/judging/run_judgement.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A study of the server with its jobs.
struct Refinement {
  v1::StudyResult result;
  std::vector<v1::Job> jobs;
  /// The report of the run of a level.
  std::string report(std::size_t level) const {
    v1::QueryResultResponse run;
    *run.add_steps() = jobs[level].last_step();
    judging::RunToJudge judged{.run = {{{jobs[level].last_step()}}, "run", {}}};
    judged.refinement = result;
    return report_page(
        {.job = jobs[level], .result = run, .judgement = judging::judge_run(judged)});
  }
};

/// Adds a run to 4 s whose corner ends at this curl; its centre stays.
void add_run(Refinement& study, int refinement, double corner_m,
             v1::JobState state = v1::SUCCEEDED) {
  v1::Job& job = study.jobs.emplace_back();
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
    monitor.set_curl_m(curl);
  }
  v1::StudyRun& run = *study.result.add_runs();
  if (state == v1::FAILED) run.mutable_failure()->set_message("did not converge");
  run.set_refinement(refinement);
  run.set_job(job.id());
  run.set_state(state);
  run.add_end_curl_m(corner_m);
  run.add_end_curl_m(0.0);
}

Refinement empty_study() {
  Refinement study;
  study.result.mutable_study()->set_id("0f2b9a4e-0000-4000-8000-000000000000");
  study.result.mutable_study()->mutable_refinement()->set_levels(3);
  study.result.add_monitors("corner");
  study.result.add_monitors("centre");
  return study;
}

/// A limit that rises evenly to these figures at 4 s.
void add_limit(Refinement& study, double corner_m, double uncertainty_m,
               std::optional<double> order = {}) {
  for (const auto& [name, part] : {std::pair("corner", 1.0), std::pair("centre", 0.0)}) {
    auto& limit = *study.result.add_limits();
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
Refinement clean_study() {
  Refinement study = empty_study();
  add_run(study, 1, 4.0e-3);
  add_run(study, 2, 4.4e-3);
  add_run(study, 4, 4.6e-3);
  add_limit(study, 4.8e-3, 0.25e-3, 1.0);
  return study;
}

/// The finest run failed.
Refinement study_with_a_loss() {
  Refinement study = empty_study();
  add_run(study, 1, 4.0e-3);
  add_run(study, 2, 4.4e-3);
  add_run(study, 4, 7.0e-3, v1::FAILED);
  add_limit(study, 4.4e-3, 1.25 * 0.4e-3);
  return study;
}

TEST(StudyPart, TheReportOfARunOfAStudyHasItsErrorItsBandAndTheTables) {
  const std::string page = clean_study().report(0);
  for (const char* const part :
       {"<strong>4.00</strong> mm<em>± 1.05 mm</em>", "<span>limit, corner</span>",
        "<strong>4.80</strong> mm<em>± 0.25 mm</em>", "corner, limit of finer meshes",
        "How much of it is discretisation", "This run has refinement 1.", ">4.600</td>",
        ">1.00</td>", ">4.800 ± 0.250</td>",
        "The curl of the corner at the end tends to 4.800 ± 0.250 mm, with order 1.00."})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(page, Not(HasSubstr("is not known")));
  EXPECT_THAT(page, Not(HasSubstr("has not been measured")));
  EXPECT_THAT(page, Not(HasSubstr(">nan")));
}

TEST(StudyPart, TheReportNamesALevelThatFailed) {
  const std::string page = study_with_a_loss().report(0);
  EXPECT_THAT(page, HasSubstr("Refinement 4 is left out: "));
  EXPECT_THAT(page, HasSubstr("did not converge"));
  EXPECT_THAT(
      page,
      HasSubstr("<span>finest mesh, corner</span><strong>4.40</strong> mm<em>± 0.50 mm</em>"));
}

TEST(StudyPart, TheReportOfAnyOtherRunNamesTheCommandThatComputesTheError) {
  Refinement study = empty_study();
  add_run(study, 1, 4.0e-3);
  add_run(study, 2, 4.4e-3, v1::RUNNING);
  EXPECT_THAT(study.report(0),
              HasSubstr("of the runs of its study 1 succeeded, two are needed. dccast convergence "
                        "--study " +
                        study.jobs[0].study()));

  study.result = {};
  const std::string page = study.report(0);
  EXPECT_THAT(page, HasSubstr("this run stands alone. dccast convergence CASE shows it."));
  EXPECT_THAT(page, Not(HasSubstr("limit of finer meshes")));
}

}  // namespace
}  // namespace dccast::client
