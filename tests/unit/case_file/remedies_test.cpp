#include "proto/case_file/remedies.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/recipe_numbers.hpp"
#include "proto/case_file/schedule.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "tests/unit/case_file/shipped_case.hpp"

namespace dccast::case_file {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

v1::Finding finding(const std::string& code) {
  v1::Finding finding;
  finding.set_code(code);
  return finding;
}

v1::Case completed_recipe(v1::Case description) {
  apply_quality(description);
  apply_defaults(description);
  return description;
}

std::vector<std::string> remedy_words(const std::string& code, const v1::Case& description) {
  std::vector<std::string> words;
  for (const Advice& advice : advice_against(finding(code)))
    for (const LeverDraft& draft : lever_drafts(advice, description))
      words.push_back(draft.step.words());
  return words;
}

/// What the drafts of `dccast remedy` may refute is no advice.
TEST(Remedies, AreNamedOnlyWhereNoDraftCanRefuteThem) {
  EXPECT_EQ(remedy_text(finding("no_superheat")), "Pour hotter.");
  EXPECT_EQ(remedy_text(finding("thin_shell")), "");
  EXPECT_EQ(remedy_text(finding("shell_melted_through")), "");
}

TEST(Remedies, OfALimitOnBothSidesFollowTheSide) {
  v1::Finding curl = finding("curl_outside_band");
  curl.set_limit(0.035);
  curl.set_value(0.050);
  EXPECT_EQ(advice_against(curl).front().direction, Direction::more);
  curl.set_value(0.010);
  EXPECT_EQ(advice_against(curl).front().direction, Direction::less);
}

TEST(Remedies, AreTriedInThreeDraftsForEachLever) {
  EXPECT_THAT(remedy_words("thin_shell", shipped_case("start-2d-thickness")),
              ElementsAre("cast 10 % slower", "cast 20 % slower", "cast 10 % faster",
                          "pour 10 K colder", "pour 20 K colder", "pour 10 K hotter"));
}

/// Slower castings end later, not shorter.
TEST(Remedies, CastTheSameLength) {
  const v1::Case base = shipped_case("start-3d");
  const double length_m = CastingSchedule(completed_recipe(base)).cast_length_at_end_m();
  int drafts = 0;
  for (const char* code : {"bottom_shell_open", "slip_too_large"})
    for (const Advice& advice : advice_against(finding(code)))
      for (const LeverDraft& draft : lever_drafts(advice, base)) {
        v1::Case changed = base;
        ASSERT_THAT(apply_changes(changed, draft.changes), IsEmpty());
        EXPECT_NEAR(CastingSchedule(completed_recipe(changed)).cast_length_at_end_m(), length_m,
                    2e-4)
            << draft.step.words();
        ++drafts;
      }
  EXPECT_EQ(drafts, 29);
}

TEST(Remedies, LeaveOutLeversThatACaseDoesNotHaveAndStepsThatItCannotTake) {
  v1::Case base = shipped_case("start-3d");
  base.mutable_schedule()->set_filling_s(50.0);  // a hold of 45 s would be shorter
  EXPECT_THAT(remedy_words("bottom_shell_open", base),
              testing::AllOf(testing::Contains("hold 30 s longer"),
                             testing::Not(testing::Contains("hold 15 s shorter"))));
  base.mutable_cooling()->mutable_water()->set_enabled(false);
  EXPECT_THAT(remedy_words("water_thrown_off", base),
              testing::Not(testing::Contains("use 15 % more water")));
}

/// Ranges of its data do not keep a shipped case from a remedy.
TEST(Remedies, ArePermittedInEachShippedCase) {
  for (const auto& shipped : shipped::case_templates())
    for (const char* code : {"curl_outside_band", "water_thrown_off", "thin_shell"})
      for (const Advice& advice : advice_against(finding(code)))
        for (const LeverDraft& draft : lever_drafts(advice, shipped_case(shipped.name))) {
          v1::Case changed = shipped_case(shipped.name);
          ASSERT_THAT(apply_changes(changed, draft.changes), IsEmpty());
          EXPECT_THAT(uncertainty_faults(completed_recipe(changed)), IsEmpty())
              << shipped.name << ": " << draft.step.words();
        }
}

/// A plant without gas can only add it; one with gas can do with less of it.
TEST(Remedies, PutGasIntoTheFirstWater) {
  const v1::Case plain = shipped_case("start-3d-aa3104"), hot = shipped_case("start-3d-aa3104-hot");
  const std::string begin = "use gas: ", end = " of the critical flux";
  EXPECT_THAT(remedy_words("curl_outside_band", plain),
              testing::IsSupersetOf({begin + "0.75" + end, begin + "0.5" + end}));
  EXPECT_THAT(remedy_words("thin_shell", plain),
              testing::Each(testing::Not(testing::StartsWith(begin))));
  EXPECT_THAT(
      remedy_words("thin_shell", hot),
      testing::IsSupersetOf({begin + "0.62" + end, begin + "0.75" + end, begin + "0.38" + end}));
}

/// The heat flux is whole again at 150 mm.
TEST(Remedies, GasIsForTheButt) {
  v1::Finding curl = finding("curl_outside_band");
  v1::Case changed = shipped_case("start-3d-aa3104");
  for (const Advice& advice : advice_against(curl))
    for (const LeverDraft& draft : lever_drafts(advice, changed))
      if (draft.step.words().find("gas: 0.5 ") != std::string::npos) {
        ASSERT_THAT(apply_changes(changed, draft.changes), IsEmpty());
      }
  const v1::Curve& factor = changed.cooling().water().critical_heat_flux_factor();
  EXPECT_EQ(factor.abscissa(), v1::CAST_LENGTH);
  EXPECT_THAT(factor.at(), ElementsAre(0.0, 0.1, 0.15));
  EXPECT_THAT(factor.value(), ElementsAre(0.5, 0.5, 1.0));
}

TEST(Remedies, OfSeveralFindingsMoveEachLeverOnceAsTheFirstFindingAsks) {
  google::protobuf::RepeatedPtrField<v1::Finding> findings;
  *findings.Add() = finding("freezes_at_meniscus");
  *findings.Add() = finding("thin_shell");
  const auto advice = advice_against(findings);
  ASSERT_EQ(advice.size(), 3U);  // speed, metal, and gas where there is some
  EXPECT_EQ(advice[0].direction, Direction::more);
  EXPECT_EQ(advice[1].direction, Direction::more);
}

}  // namespace
}  // namespace dccast::case_file
