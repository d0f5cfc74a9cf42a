#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "client/html/pages.hpp"
#include "client/text/data_study_text.hpp"
#include "client/text/terminal.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Two recipes of eight numbers; the second one is confirmed.
v1::StudyResult recipes() {
  v1::StudyResult result;
  v1::RecipePlan& plan = *result.mutable_study()->mutable_recipe();
  for (const char* name : {"speed_start", "speed_run", "speed_ramp", "filling", "hold",
                           "water_start", "water_run", "water_ramp"})
    plan.add_numbers()->set_name(name);
  plan.set_least_curl_m(0.035);
  plan.set_greatest_curl_m(0.045);
  v1::RecipeFound& found = *result.mutable_recipe();
  found.set_monitor("middle of the narrow face");
  found.set_runs(128);
  found.set_dangers(12);
  found.set_full_over_draft(1.05);
  found.set_surface_error_m(2.6e-3);
  found.set_misjudged(0.04);
  found.set_chosen(1);
  for (const double risk : {0.12, 0.2}) {
    auto& candidate = *found.add_front();
    for (const double number : {40.0 / 60e3, 60.0 / 60e3, 140.0, 30.0, 60.0, 1.5e-3, 3e-3, 141.4})
      candidate.add_numbers(number);
    candidate.set_low_m(0.0312);
    candidate.set_high_m(0.1445);
    candidate.set_risk(risk);
    candidate.set_risk_error(0.06);
    candidate.set_castings(12);
    candidate.set_lost(1);
    candidate.set_casting_time_s(1310.4);
    candidate.set_full_state(v1::SUCCEEDED);
    candidate.set_full_curl_m(risk > 0.15 ? 0.04 : 0.05);
  }
  v1::CaseChange& change = *found.mutable_front(1)->add_changes();
  change.set_key("schedule.hold");
  change.set_value("60 s");
  *found.mutable_itself() = found.front(0);
  found.mutable_itself()->set_castings(0);
  return result;
}

TEST(RecipeText, ShowsTheFrontTheChosenOneAndWhatItRestsOn) {
  const std::string text = render::recipe_text(recipes());
  EXPECT_THAT(text, HasSubstr("40 to 60     140      30      60      90 to 180   141.4"));
  EXPECT_THAT(text, HasSubstr("12 ± 10"));
  EXPECT_THAT(text, HasSubstr("50.0 !")) << "outside the band";
  EXPECT_THAT(text, HasSubstr("Recipe 2: 20 ± 10 % of castings"));
  EXPECT_THAT(text, HasSubstr("It is schedule.hold = 60 s."));
  EXPECT_THAT(text, HasSubstr("off by 2.6 mm"));
  EXPECT_THAT(text, Not(HasSubstr("No recipe")));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    EXPECT_LE(render::display_width(line), 120) << line;
  const std::string page = render::recipe_page(recipes());
  EXPECT_THAT(page, HasSubstr("Recipes of least risk"));
  EXPECT_THAT(page, HasSubstr("<circle"));
}

TEST(RecipeText, SaysWhereNothingIsSafeOrConfirmedOrThere) {
  auto lost = recipes();
  for (auto& candidate : *lost.mutable_recipe()->mutable_front()) candidate.set_risk(0.9);
  EXPECT_THAT(render::recipe_text(lost), HasSubstr("No recipe within these limits is safe"));
  auto unconfirmed = recipes();
  unconfirmed.mutable_recipe()->set_chosen(-1);
  EXPECT_THAT(render::recipe_text(unconfirmed), HasSubstr("No recipe is confirmed: the run"));
  unconfirmed.mutable_recipe()->mutable_front(0)->set_full_state(v1::QUEUED);
  EXPECT_THAT(render::recipe_text(unconfirmed), HasSubstr("are to come"));
  v1::StudyResult open;
  open.mutable_recipe()->set_fault("the drafts of this study have not all ended");
  EXPECT_THAT(render::recipe_text(open), HasSubstr("No answer yet: the drafts"));
  EXPECT_THAT(render::recipe_page(open), HasSubstr("No answer yet"));
}

}  // namespace
}  // namespace dccast::client
