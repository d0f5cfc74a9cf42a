#include "proto/case_file/live_levers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/recipe_numbers.hpp"
#include "proto/case_file/schedule.hpp"
#include "tests/unit/case_file/shipped_case.hpp"

namespace dccast::case_file {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

v1::Case completed(v1::Case description) {
  apply_defaults(description);
  return description;
}

/// The complete case of a draft.
v1::Case moved(v1::Case description, const LeverDraft& draft) {
  EXPECT_THAT(apply_changes(description, draft.changes), IsEmpty());
  return completed(description);
}

double speed_at(const v1::Case& complete, double time_s) {
  const CastingSchedule plan(complete);
  return plan.speed_m_per_s({time_s, plan.cast_length_m(time_s)});
}

std::vector<std::string> words_of(const std::vector<LeverDraft>& drafts) {
  std::vector<std::string> words;
  for (const LeverDraft& draft : drafts) words.push_back(draft.step.words());
  return words;
}

TEST(LiveLevers, AreNamedInTheTermsOfAPlant) {
  v1::Case base = shipped_case("start-3d");
  EXPECT_THAT(words_of(lever_drafts_from(base, 40.0)),
              ElementsAre("cast 10 % slower", "cast 10 % faster", "use 20 % less water",
                          "use 20 % more water", "pour 10 K colder", "pour 10 K hotter"));

  base.mutable_schedule()->mutable_narrow_water_flow_m2_per_s()->add_value(2e-3);
  const auto words = words_of(lever_drafts_from(base, 40.0));
  ASSERT_EQ(words.size(), 8u);
  EXPECT_EQ(words[2], "use 20 % less water on the wide faces");
  EXPECT_EQ(words[4], "use 20 % less water on the narrow faces");
}

TEST(LiveLevers, FollowThePlanUntilTheyAreMoved) {
  const v1::Case base = shipped_case("start-3d");
  const v1::Case slower = moved(base, lever_drafts_from(base, 90.0).front());
  for (const double time_s : {0.0, 40.0, 89.9})
    EXPECT_DOUBLE_EQ(speed_at(slower, time_s), speed_at(completed(base), time_s)) << time_s;
  for (const double time_s : {90.0, 130.0, 240.0})
    EXPECT_DOUBLE_EQ(speed_at(slower, time_s), 0.9 * speed_at(completed(base), time_s)) << time_s;
}

/// Slower castings end later, not shorter.
TEST(LiveLevers, CastTheSameLength) {
  const v1::Case base = shipped_case("start-3d");
  const double length_m = CastingSchedule(completed(base)).cast_length_at_end_m();
  for (const double from_s : {0.0, 60.0, 200.0})
    for (const LeverDraft& draft : lever_drafts_from(base, from_s))
      EXPECT_NEAR(CastingSchedule(moved(base, draft)).cast_length_at_end_m(), length_m, 2e-4)
          << draft.step.words();
}

TEST(LiveLevers, OfATableByCastLengthAreMovedWhereTheCastingIsThen) {
  v1::Case base = shipped_case("start-3d");
  v1::Curve& speed = *base.mutable_schedule()->mutable_casting_speed_m_per_s();
  speed.Clear();
  speed.set_abscissa(v1::CAST_LENGTH);
  for (const double at : {0.0, 0.1}) speed.add_at(at);
  for (const double value : {0.7e-3, 1e-3}) speed.add_value(value);

  const v1::Case faster = moved(base, lever_drafts_from(base, 50.0)[1]);
  EXPECT_NEAR(speed_at(faster, 49.9), speed_at(completed(base), 49.9), 1e-9);
  EXPECT_NEAR(speed_at(faster, 50.1), 1.1 * speed_at(completed(base), 50.1), 1e-7);
}

/// A table that comes later is moved at the time of the casting, not of the table.
TEST(LiveLevers, OfAShiftedTableAreMovedAtTheTimeOfTheCasting) {
  v1::Case base = shipped_case("start-3d");
  base.mutable_schedule()->set_casting_speed_shift_s(20.0);
  const v1::Case slower = moved(base, lever_drafts_from(base, 90.0).front());
  EXPECT_DOUBLE_EQ(speed_at(slower, 89.9), speed_at(completed(base), 89.9));
  EXPECT_DOUBLE_EQ(speed_at(slower, 90.1), 0.9 * speed_at(completed(base), 90.1));
}

TEST(LiveLevers, OfASingleValueBecomeAStep) {
  v1::Case base = shipped_case("start-3d");
  v1::Curve& metal = *base.mutable_schedule()->mutable_casting_temperature_c();
  metal.Clear();
  metal.add_value(680.0);
  const v1::Curve colder =
      moved(base, lever_drafts_from(base, 30.0)[4]).schedule().casting_temperature_c();
  EXPECT_EQ(curve_value(colder, 29.0), 680.0);
  EXPECT_EQ(curve_value(colder, 30.0), 670.0);
  EXPECT_EQ(curve_value(colder, 200.0), 670.0);
}

}  // namespace
}  // namespace dccast::case_file
