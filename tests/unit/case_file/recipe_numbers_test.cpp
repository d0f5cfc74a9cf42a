#include "proto/case_file/recipe_numbers.hpp"

#include <gtest/gtest.h>

#include "proto/case_file/override.hpp"
#include "proto/case_file/schedule.hpp"

namespace dccast::case_file {
namespace {

constexpr double mm_per_min = 1.0 / 60e3;

/// 40 to 60 mm/min from 60 to 200 s, the water doubled in the same time.
v1::Case start() {
  v1::Case c;
  v1::Schedule& schedule = *c.mutable_schedule();
  schedule.set_hold_s(60.0);
  schedule.set_filling_s(30.0);
  for (auto* const curve :
       {schedule.mutable_casting_speed_m_per_s(), schedule.mutable_water_flow_m2_per_s()}) {
    curve->set_abscissa(v1::TIME);
    curve->add_at(60.0);
    curve->add_at(200.0);
  }
  schedule.mutable_casting_speed_m_per_s()->add_value(40.0 * mm_per_min);
  schedule.mutable_casting_speed_m_per_s()->add_value(60.0 * mm_per_min);
  schedule.mutable_water_flow_m2_per_s()->add_value(1.5e-3);
  schedule.mutable_water_flow_m2_per_s()->add_value(3e-3);
  c.mutable_time()->set_end_s(250.0);
  return c;
}

TEST(RecipeNumbers, AreThoseOfTheTables) {
  const Recipe recipe = recipe_of(start());
  EXPECT_EQ(recipe[speed_start], 40.0 * mm_per_min);
  EXPECT_EQ(recipe[speed_run], 60.0 * mm_per_min);
  EXPECT_EQ(recipe[speed_ramp], 140.0);
  EXPECT_EQ(recipe[filling], 30.0);
  EXPECT_EQ(recipe[hold], 60.0);
  EXPECT_EQ(recipe[water_run], 3e-3);
  EXPECT_EQ(recipe_names[water_ramp], std::string("water_ramp"));
  EXPECT_TRUE(recipe_changes(start(), recipe).empty());
}

/// Mechanics that begins with the full mould goes on doing so; a start of the case's own stays.
TEST(RecipeNumbers, AnotherFillingMovesTheStartOfTheMechanics) {
  for (const double start_s : {-30.0, 0.0}) {
    v1::Case before = start();
    before.mutable_mechanics()->set_start_s(start_s);
    Recipe recipe = recipe_of(before);
    recipe[filling] = 50.6;
    recipe[hold] = 59.88;
    v1::Case after = before;
    const auto changes = recipe_changes(before, recipe);
    ASSERT_TRUE(apply_changes(after, changes).empty());
    EXPECT_NEAR(after.mechanics().start_s(), start_s == 0.0 ? 0.0 : 50.6 - 59.88, 1e-9);
    for (const auto& change : changes)
      if (change.key() == "mechanics.start") {
        EXPECT_EQ(change.value(), "-9.28 s");
      }
  }
}

TEST(RecipeNumbers, AnotherSpeedCastsTheSameLength) {
  const v1::Case before = start();
  // 60 s at 40, 140 s at 50 on the mean, 50 s at 60 mm/min.
  EXPECT_NEAR(CastingSchedule(before).cast_length_at_end_m(),
              1e-3 * (40.0 + 140.0 * 50.0 / 60.0 + 50.0), 1e-6);
  Recipe recipe = recipe_of(before);
  recipe[speed_start] = 30.0 * mm_per_min;
  recipe[speed_run] = 50.0 * mm_per_min;
  recipe[speed_ramp] = 100.0;
  recipe[hold] = 71.23456;
  v1::Case after = before;
  const auto changes = recipe_changes(before, recipe);
  ASSERT_EQ(changes.size(), 3U);
  EXPECT_EQ(changes[0].value(), R"([["60 s", "30 mm/min"], ["160 s", "50 mm/min"]])");
  EXPECT_EQ(changes[1].value(), "71.23 s");
  ASSERT_TRUE(apply_changes(after, changes).empty());
  EXPECT_NEAR(recipe_of(after)[speed_ramp], 100.0, 1e-9);
  EXPECT_NEAR(CastingSchedule(after).cast_length_at_end_m(),
              CastingSchedule(before).cast_length_at_end_m(), 1e-4);
  EXPECT_GT(after.time().end_s(), before.time().end_s());
  EXPECT_NEAR(
      CastingSchedule(after).time_of_cast_length_s(CastingSchedule(before).cast_length_at_end_m()),
      after.time().end_s(), 0.06);
}

TEST(RecipeNumbers, WaterAloneLeavesSpeedAndEnd) {
  Recipe recipe = recipe_of(start());
  recipe[water_start] = 1.23456e-3;
  const auto changes = recipe_changes(start(), recipe);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].key(), "schedule.water_flow");
  v1::Case after = start();
  ASSERT_TRUE(apply_changes(after, changes).empty());
  EXPECT_NEAR(after.schedule().water_flow_m2_per_s().value(0), 74.07 / 60e3, 1e-12);
  EXPECT_NE(changes[0].value().find("74.07 l/min/m"), std::string::npos) << "as a plant puts it";
}

TEST(RecipeNumbers, ARampMayStandAgainstCastLength) {
  v1::Case c = start();
  v1::Curve& speed = *c.mutable_schedule()->mutable_casting_speed_m_per_s();
  speed.set_abscissa(v1::CAST_LENGTH);
  speed.set_at(0, 0.05);
  speed.set_at(1, 0.15);
  Recipe recipe = recipe_of(c);
  EXPECT_NEAR(recipe[speed_ramp], 0.1, 1e-12);
  recipe[speed_ramp] = 0.2;
  v1::Case after = c;
  ASSERT_TRUE(apply_changes(after, recipe_changes(c, recipe)).empty());
  EXPECT_NEAR(after.schedule().casting_speed_m_per_s().at(1), 0.25, 1e-12);
  EXPECT_NEAR(CastingSchedule(after).cast_length_at_end_m(),
              CastingSchedule(c).cast_length_at_end_m(), 1e-4);
}

TEST(RecipeNumbers, OneValueIsBothLevelsAndACaseThatStandsStillNeverArrives) {
  v1::Case c = start();
  v1::Curve& speed = *c.mutable_schedule()->mutable_casting_speed_m_per_s();
  speed.Clear();
  speed.add_value(50.0 * mm_per_min);
  Recipe recipe = recipe_of(c);
  EXPECT_EQ(recipe[speed_start], recipe[speed_run]);

  recipe[speed_start] = 40.0 * mm_per_min;
  v1::Case after = c;
  ASSERT_TRUE(apply_changes(after, recipe_changes(c, recipe)).empty());
  EXPECT_EQ(after.schedule().casting_speed_m_per_s().at_size(), 2);

  speed.set_value(0, 0.0);
  EXPECT_EQ(CastingSchedule(c).cast_length_at_end_m(), 0.0);
  EXPECT_GT(CastingSchedule(c).time_of_cast_length_s(0.1), 1e9);
}

}  // namespace
}  // namespace dccast::case_file
