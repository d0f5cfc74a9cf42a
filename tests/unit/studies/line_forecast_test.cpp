#include "server/studies/curl_forecast.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "server/studies/past_forecasts.hpp"
#include "tests/support/shaped_castings.hpp"

namespace dccast::studies {
namespace {

/// The ensemble on another recipe: its castings curl half as much.
v1::StudyResult other_recipe() {
  v1::StudyResult runs = ensemble(21);
  for (v1::StudyRun& run : *runs.mutable_runs())
    for (double& curl : *run.mutable_curves(0)->mutable_curl_m()) curl *= 0.5;
  return runs;
}

/// A casting that has ended: all its readings, on a recipe.
EarlierCasting earlier(const v1::StudyResult& recipe, const std::vector<v1::Reading>& measured,
                       const std::string& job = "job-1") {
  EarlierCasting casting{.casting = {},
                         .ensemble = std::make_shared<v1::StudyResult>(recipe),
                         .pairs = std::make_shared<v1::StudyResult>()};
  const auto curls = ask_of(recipe, measured, observed_curls, *casting.pairs, 1e-3);

  casting.casting.set_job(job);
  casting.casting.set_ended(true);
  *casting.casting.mutable_following() = following(1e-3);
  *casting.casting.mutable_curls() = {curls.begin(), curls.end()};
  return casting;
}

v1::Forecast on_line(const v1::StudyResult& runs, const std::vector<EarlierCasting>& castings) {
  v1::Following with = following(1e-3);
  with.set_line("pit-3");
  const v1::Case complete = plan();
  const v1::StudyResult none;
  return forecast_curls({.ensemble = runs,
                         .pairs = none,
                         .plan = complete,
                         .following = with,
                         .readings = {},
                         .earlier = castings});
}

TEST(LineForecast, CastingsOnALineTellTheNextOneBeforeItBegins) {
  const v1::StudyResult runs = ensemble(21);
  const auto alone = on_line(runs, {});
  EXPECT_EQ(alone.curls(0).line().castings(), 0);
  EXPECT_EQ(*alone.curls(0).curl_m().rbegin(), *forecast(runs, {}).curl_m().rbegin());

  double width = width_at_end(alone.curls(0));
  for (const int count : {1, 4}) {
    const std::vector<EarlierCasting> castings(count, earlier(runs, readings(1.15, end_s)));
    const auto curl = on_line(runs, castings).curls(0);
    EXPECT_EQ(curl.line().castings(), count);
    EXPECT_EQ(curl.members(), 21);
    EXPECT_LT(width_at_end(curl), 0.9 * width);
    EXPECT_NEAR(*curl.curl_m().rbegin(), 1.15 * shape(end_s), 0.25 * width);
    width = width_at_end(curl);
  }
}

TEST(LineForecast, ACastingOnOneRecipeInformsAnother) {
  const v1::StudyResult runs = other_recipe();
  const std::vector<EarlierCasting> castings(4, earlier(ensemble(21), readings(1.15, end_s)));
  const auto curl = on_line(runs, castings).curls(0);
  EXPECT_EQ(curl.line().castings(), 4);
  EXPECT_NEAR(curl.before().curl_m(), 0.5 * 1.15 * shape(end_s), 0.02 * shape(end_s));
  EXPECT_LT(width_at_end(curl), 0.5 * width_at_end(on_line(runs, {}).curls(0)));
}

/// Castings that differ much tell less than those that are alike, and show a larger scatter.
TEST(LineForecast, TellsTheScatterFromCastingToCasting) {
  const v1::StudyResult runs = ensemble(21);
  std::vector<EarlierCasting> alike, scattered;
  for (int i = 0; i < 6; ++i) {
    alike.push_back(earlier(runs, readings(1.1 + 0.005 * (i % 3), end_s)));
    scattered.push_back(earlier(runs, readings(0.9 + 0.2 * (i % 2), end_s)));
  }
  const auto same = on_line(runs, alike).curls(0), other = on_line(runs, scattered).curls(0);
  EXPECT_LT(same.line().scatter(), 0.2);
  EXPECT_GT(other.line().scatter(), 0.4);
  EXPECT_LT(width_at_end(same), 0.7 * width_at_end(other));
}

TEST(LineForecast, LeavesOutCastingsWithOtherDataAndWithoutTheirStudy) {
  const v1::StudyResult runs = ensemble(21);
  v1::StudyResult of_other_data = runs;
  for (v1::StudyRun& run : *of_other_data.mutable_runs()) run.set_values(0, run.values(0) + "/2");

  auto lost = earlier(runs, readings(1.15, end_s), "job-2");
  lost.ensemble.reset();
  const auto whole = on_line(runs, {earlier(of_other_data, readings(1.15, end_s)), lost});
  EXPECT_EQ(whole.curls(0).line().castings(), 0);
  EXPECT_THAT(whole.notes(),
              ::testing::ElementsAre(
                  ::testing::HasSubstr("job job-2 on the line does not count: its study"),
                  ::testing::HasSubstr("job job-1 on the line does not count: its "
                                       "ensemble has other data")));

  // The other key, with the same values, is other data too.
  v1::StudyResult of_other_key = runs;
  of_other_key.mutable_study()->mutable_sweep()->add_axes()->set_key("schedule.hold");
  EXPECT_EQ(on_line(runs, {earlier(of_other_key, readings(1.15, end_s))}).notes_size(), 1);
}

}  // namespace
}  // namespace dccast::studies
