#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/shipped.hpp"
#include "server/judging/judged_study.hpp"
#include "tests/support/judged_table.hpp"

namespace dccast::judging {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A shipped quarter slab with all its defaults: its pairs have a measured error.
v1::Case slab(v1::Quality quality) {
  v1::Case description;
  const auto* const shipped = shipped::find(shipped::case_templates(), "start-3d");
  EXPECT_TRUE(case_file::read_text(shipped->text, shipped->name, description).ok());
  description.set_quality(quality);
  case_file::apply_defaults(description);
  return description;
}

v1::Finding thin_shell(double time_s, double value) {
  v1::Finding finding;
  finding.set_code("thin_shell");
  finding.set_severity(v1::Finding::WARNING);
  finding.set_unit("m");
  finding.set_time_s(time_s);
  finding.set_value(value);
  return finding;
}

/// What a run of the study came to.
struct Outcome {
  double least_shell_m = 0.0;  ///< from 50 mm of cast length on; three times as thick before
  double corner_m = 0.0;       ///< at the end
  double speed = 1e-3;         ///< [m/s]
  v1::Quality quality = v1::DRAFT;
};

/// A study of the finding thin_shell with a limit of 5 mm, run by run.
class Study {
public:
  Study() {
    v1::Study& study = *result_.mutable_study();
    *study.mutable_remedy()->add_findings() = thin_shell(50.0, 3e-3);
    result_.add_monitors("corner");
  }

  v1::StudyRun& add(const Outcome& outcome) {
    JudgedRun run;
    run.description = slab(outcome.quality);
    for (int i = 1; i <= 20; ++i) {
      v1::StepReport& step = run.steps.emplace_back();
      step.set_time_s(1e-2 * i / outcome.speed);
      step.set_cast_length_m(1e-2 * i);
      step.set_least_shell_m(i < 5 ? 3.0 * outcome.least_shell_m : outcome.least_shell_m);
      v1::MonitorValue& corner = *step.add_monitors();
      corner.set_name("corner");
      corner.add_displacement_m(0.0);
      corner.add_displacement_m(outcome.corner_m * i / 20.0);
      corner.set_curl_m(corner.displacement_m(1));
      corner.set_judged(true);
    }
    runs_.push_back(run);

    v1::StudyRun& added = *result_.add_runs();
    added.set_state(v1::SUCCEEDED);
    added.set_job("job");
    added.add_end_curl_m(outcome.corner_m);
    if (outcome.least_shell_m < 5e-3)
      *added.add_findings() = thin_shell(0.05 / outcome.speed, outcome.least_shell_m);
    return added;
  }

  v1::StudyRun& add(const std::string& key, int steps, const std::string& words,
                    const Outcome& outcome) {
    v1::StudyRun& run = add(outcome);
    run.mutable_lever_step()->set_key(key);
    run.mutable_lever_step()->set_steps(steps);
    run.mutable_lever_step()->set_words(words);
    return run;
  }

  v1::Judgement judged() const { return judge_study({.result = result_, .runs = runs_}); }

private:
  v1::StudyResult result_;
  std::vector<JudgedRun> runs_;
};

/// The case with a shell of 3.0 mm as a draft, 3.5 mm at engineering.
Study started() {
  Study study;
  study.add({.least_shell_m = 3e-3, .corner_m = 0.040});
  study.add({.least_shell_m = 3.5e-3, .corner_m = 0.042, .quality = v1::ENGINEERING});
  return study;
}

TEST(Remedy, NamesTheSmallestStepAfterWhichTheFindingHasGone) {
  Study study = started();
  study.add("hold", 1, "hold 15 s longer", {.least_shell_m = 6e-3, .corner_m = 0.030});
  study.add("hold", 2, "hold 30 s longer", {.least_shell_m = 9e-3, .corner_m = 0.025});
  study.add("hold", -1, "hold 15 s shorter", {.least_shell_m = 2e-3, .corner_m = 0.045});
  EXPECT_THAT(study.judged().sentences(),
              ElementsAre("thin_shell goes: hold 15 s longer: least shell 3.0 -> 6.0 mm; corner "
                          "-10.0 ± 4.0 mm.",
                          "thin_shell: of no help: hold 15 s shorter."));
}

TEST(Remedy, NamesNoLeverWhoseEffectIsWithinItsError) {
  Study study = started();
  study.add("hold", 1, "hold 15 s longer", {.least_shell_m = 3.3e-3, .corner_m = 0.030});
  study.add("hold", 2, "hold 30 s longer", {.least_shell_m = 3.4e-3, .corner_m = 0.030});
  const v1::Judgement judgement = study.judged();
  EXPECT_THAT(judgement.sentences(), ElementsAre("thin_shell: no lever was found."));
  EXPECT_EQ(support::table_of(judgement, "remedy_thin_shell").rows(1).cells(2).code(),
            "within_its_error");
}

TEST(Remedy, WithoutASecondQualityNoErrorIsKnownAndNoLeverIsNamed) {
  Study study;
  study.add({.least_shell_m = 3e-3, .corner_m = 0.040});
  study.add("hold", 1, "hold 15 s longer", {.least_shell_m = 9e-3, .corner_m = 0.030});
  EXPECT_THAT(study.judged().sentences(), ElementsAre("thin_shell: no lever was found."));
}

TEST(Remedy, OfALeverThatEndsNoFindingTheMostEffectiveStepIsNamed) {
  Study study = started();
  study.add("speed", -1, "cast 10 % slower", {.least_shell_m = 3.8e-3, .corner_m = 0.040});
  study.add("speed", -2, "cast 20 % slower", {.least_shell_m = 4.6e-3, .corner_m = 0.040});
  EXPECT_THAT(study.judged().sentences(),
              ElementsAre("thin_shell stays: cast 20 % slower: least shell 3.0 -> 4.6 mm."));
}

/// Half the speed casts the same length in twice the time, with the same curl at that length.
TEST(Remedy, ComparesAtEqualCastLength) {
  Study study = started();
  study.add("speed", -2, "cast 20 % slower",
            {.least_shell_m = 6e-3, .corner_m = 0.040, .speed = 0.8e-3});
  const v1::Table table = support::table_of(study.judged(), "remedy_thin_shell");
  EXPECT_NEAR(table.rows(1).cells(4).value(), 0.0, 1e-9);
  EXPECT_THAT(study.judged().sentences(), ElementsAre(Not(HasSubstr("corner"))));
}

TEST(Remedy, ADraftThatRaisesAnotherDangerIsNoRemedy) {
  Study study = started();
  v1::Finding& danger =
      *study.add("hold", 1, "hold 15 s longer", {.least_shell_m = 9e-3, .corner_m = 0.030})
           .add_findings();
  danger.set_code("sump_too_deep");
  danger.set_severity(v1::Finding::DANGER);
  const v1::Judgement judgement = study.judged();
  EXPECT_THAT(judgement.sentences(), ElementsAre("thin_shell: no lever was found."));
  EXPECT_EQ(support::table_of(judgement, "remedy_thin_shell").rows(1).cells(5).text(),
            "sump_too_deep");
}

TEST(Remedy, AWarningThatADraftRaisesIsNamed) {
  Study study = started();
  v1::Finding& warning =
      *study.add("hold", 1, "hold 15 s longer", {.least_shell_m = 9e-3, .corner_m = 0.040})
           .add_findings();
  warning.set_code("freezes_at_meniscus");
  warning.set_severity(v1::Finding::WARNING);
  EXPECT_THAT(study.judged().sentences(), ElementsAre(HasSubstr("; raises freezes_at_meniscus.")));
}

TEST(Remedy, AFindingThatTheDraftDoesNotHaveIsSaidToBeSo) {
  Study study;
  study.add({.least_shell_m = 6e-3, .corner_m = 0.040});
  EXPECT_THAT(study.judged().sentences(),
              ElementsAre(AllOf(HasSubstr("thin_shell"), HasSubstr("does not have this finding"))));
}

/// The step that ends a run is not reported; its finding has the value.
TEST(Remedy, TheValueOfARunThatWasEndedIsThatOfItsFinding) {
  Study study = started();
  v1::StudyRun& lost =
      study.add("speed", 1, "cast 10 % faster", {.least_shell_m = 3.2e-3, .corner_m = 0.030});
  lost.set_state(v1::FAILED);
  lost.mutable_findings(0)->mutable_worst()->set_value(0.0);
  const v1::Table table = support::table_of(study.judged(), "remedy_thin_shell");
  EXPECT_EQ(table.rows(1).cells(1).value(), 0.0);
  EXPECT_THAT(study.judged().sentences(), ElementsAre("thin_shell: no lever was found."));
}

TEST(Remedy, WithoutTheCaseItselfThereIsNothingToCompareWith) {
  Study study;
  EXPECT_THAT(study.judged().sentences(), ElementsAre(HasSubstr("nothing to compare with")));
}

}  // namespace
}  // namespace dccast::judging
