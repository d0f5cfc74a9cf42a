#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/judging/judged_study.hpp"

namespace dccast::judging {
namespace {

using testing::Contains;
using testing::ElementsAre;
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

  // The second candidate is riskier, but its full run ends inside the band.
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

v1::Judgement judged_recipe(const v1::StudyResult& result) {
  return judge_study({result});
}

/// The cell of a row in the column with this key.
v1::Cell cell_of(const v1::Table& table, int row, const std::string& key) {
  for (int i = 0; i < table.columns_size(); ++i)
    if (table.columns(i).key() == key) return table.rows(row).cells(i);
  ADD_FAILURE() << key;
  return {};
}

TEST(Recipe, ShowsTheFrontTheChosenOneAndWhatItRestsOn) {
  const v1::Judgement judgement = judged_recipe(recipes());
  EXPECT_THAT(judgement.sentences(0), HasSubstr("Recipe 2: 20 ± 10 % of castings"));
  EXPECT_THAT(judgement.sentences(), Contains("It is schedule.hold = 60 s."));
  EXPECT_THAT(judgement.sentences(), Contains(HasSubstr("off by 2.6 mm")));
  EXPECT_THAT(judgement.sentences(), Not(Contains(HasSubstr("No recipe"))));

  const v1::Table& table = judgement.parts(0).table();
  EXPECT_THAT(table.heading(), HasSubstr("recipes of least risk"));
  ASSERT_EQ(table.rows_size(), 3) << "and the case itself";
  EXPECT_DOUBLE_EQ(cell_of(table, 0, "speed_start").value(), 40.0 / 60e3);
  EXPECT_DOUBLE_EQ(cell_of(table, 0, "speed_start").until(), 60.0 / 60e3);
  EXPECT_DOUBLE_EQ(cell_of(table, 0, "water_ramp").value(), 141.4);
  EXPECT_DOUBLE_EQ(cell_of(table, 0, "curl").until(), 0.1445);
  EXPECT_NEAR(cell_of(table, 0, "risk").upper_error(), 1.645 * 0.06, 1e-12);
  EXPECT_DOUBLE_EQ(cell_of(table, 0, "full_curl").value(), 0.05);
  EXPECT_EQ(cell_of(table, 0, "full_curl").code(), "out") << "of the band";
  EXPECT_EQ(cell_of(table, 1, "full_curl").code(), "");
  EXPECT_FALSE(cell_of(table, 2, "lost").has_value()) << "by the surface alone";
}

TEST(Recipe, NumbersThatThePlanLeavesAloneHaveNoColumn) {
  v1::StudyResult result = recipes();
  v1::RecipePlan& plan = *result.mutable_study()->mutable_recipe();
  plan.mutable_numbers()->DeleteSubrange(3, 1);
  for (auto& candidate : *result.mutable_recipe()->mutable_front())
    candidate.mutable_numbers()->erase(candidate.numbers().begin() + 3);
  const v1::Judgement judgement = judged_recipe(result);
  for (const auto& column : judgement.parts(0).table().columns())
    EXPECT_NE(column.key(), "filling");
  EXPECT_DOUBLE_EQ(cell_of(judgement.parts(0).table(), 0, "hold").value(), 60.0);
}

TEST(Recipe, SaysWhereNoRecipeHoldsIsConfirmedOrThere) {
  auto lost = recipes();
  for (auto& candidate : *lost.mutable_recipe()->mutable_front()) candidate.set_risk(0.9);
  EXPECT_THAT(judged_recipe(lost).sentences(),
              Contains(HasSubstr("No recipe within these limits stays without a danger")));

  auto unconfirmed = recipes();
  unconfirmed.mutable_recipe()->set_chosen(-1);
  EXPECT_THAT(judged_recipe(unconfirmed).sentences(0),
              HasSubstr("No recipe is confirmed: the run"));

  unconfirmed.mutable_recipe()->mutable_front(0)->set_full_state(v1::QUEUED);
  EXPECT_THAT(judged_recipe(unconfirmed).sentences(0), HasSubstr("are to come"));

  v1::StudyResult open;
  open.mutable_study()->mutable_recipe();
  open.mutable_recipe()->set_fault("the drafts of this study have not all ended");
  EXPECT_THAT(judged_recipe(open).sentences(), ElementsAre(HasSubstr("No answer yet: the drafts")));
}

}  // namespace
}  // namespace dccast::judging
