#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/case_file/case_file.hpp"
#include "server/judging/judged_study.hpp"
#include "tests/support/study_result.hpp"

namespace dccast::judging {
namespace {

using testing::HasSubstr;

/// A calibration of the hold, which the file of the case does not give.
v1::StudyResult calibrated(const std::string& key, const std::string& best) {
  v1::StudyResult result;
  result.mutable_study()->set_id("id");
  support::add_axis(result, key, "40 s", "80 s");
  v1::Calibration& calibration = *result.mutable_calibration();
  calibration.add_curves()->mutable_measured()->set_source("curl.csv");
  v1::Calibration::Key& found = *calibration.add_keys();
  found.set_best(50.0);
  found.set_best_text(best);
  found.set_low(45.0);
  found.set_low_text("45 s");
  found.set_high(55.0);
  found.set_high_text("55 s");
  return result;
}

TEST(FoundCase, HasTheCalibratedValueItsRangeAndWhereItIsFrom) {
  v1::Case submitted;
  submitted.set_title("mine");
  v1::Case complete = submitted;
  complete.mutable_schedule()->set_hold_s(60.0);

  const std::string text = found_case(calibrated("schedule.hold", "50 s"), submitted, complete);
  EXPECT_THAT(text,
              testing::StartsWith("# calibrated from curl.csv by dccast calibrate, study id."));
  EXPECT_THAT(text, HasSubstr("#   schedule.hold = 50 s; before: 40..80 s, after: 45 s to 55 s"));
  EXPECT_THAT(text, HasSubstr("\"schedule.hold\" = \"45..55 s\"  # calibrated from curl.csv"));

  v1::Case read;
  case_file::read_text(text, "found", read);
  EXPECT_EQ(read.schedule().hold_s(), 50.0);
  EXPECT_EQ(read.title(), "mine");
}

TEST(FoundCase, AValueThatDoesNotFitIsRefused) {
  EXPECT_THROW(found_case(calibrated("schedule.hold", "50 mm"), {}, {}), UnfitCase);
}

TEST(FoundCase, HasTheChosenRecipeAndNothingWithoutOne) {
  v1::StudyResult result;
  v1::RecipeFound& recipe = *result.mutable_recipe();
  recipe.set_chosen(-1);
  EXPECT_EQ(found_case(result, {}, {}), "");

  v1::CaseChange& change = *recipe.add_front()->add_changes();
  change.set_key("schedule.casting_speed");
  change.set_value("55 mm/min");
  recipe.set_chosen(0);
  EXPECT_THAT(found_case(result, {}, {}), HasSubstr("casting_speed = \"55 mm/min\""));
}

}  // namespace
}  // namespace dccast::judging
