#include "proto/case_file/slab_recipe.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/shipped.hpp"

namespace dccast::case_file {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr double per_hour = 1.0 / 3600.0, mm_per_min = 1e-3 / 60.0;

SlabRecipe recipe() {
  return {.slab = "1320x570mm", .alloy = "aa5182", .speed = "45..55mm/min", .water = "25..45m3/h"};
}

v1::Case read(const std::string& text) {
  v1::Case description;
  const auto outcome = case_file::read_text(text, "made", description);
  for (const v1::Fault& fault : outcome.faults)
    ADD_FAILURE() << case_file::describe(fault, outcome.source);
  return description;
}

v1::Case made(const SlabRecipe& recipe) {
  const NewCase made = new_case(recipe);
  EXPECT_THAT(made.faults, IsEmpty());
  return read(made.text);
}

v1::Case shipped_case(const std::string& name) {
  for (const auto& one : shipped::case_templates())
    if (one.name == name) {
      v1::Case description = read(one.text);
      case_file::apply_defaults(description);
      return description;
    }
  ADD_FAILURE() << name;
  return {};
}

TEST(NewCase, HasWhatItsRecipeGives) {
  const v1::Case c = made(recipe());
  EXPECT_DOUBLE_EQ(c.section().half_width_m(), 0.66);
  EXPECT_DOUBLE_EQ(c.section().half_thickness_m().value(0), 0.285);
  EXPECT_EQ(c.alloy().card(), "aa5182");
  EXPECT_NEAR(c.schedule().casting_speed_m_per_s().value(0), 45 * mm_per_min, 1e-9);
  EXPECT_NEAR(c.schedule().casting_speed_m_per_s().value(1), 55 * mm_per_min, 1e-9);
}

TEST(NewCase, TotalWaterIsSharedByThePerimeter) {
  const v1::Curve flow = made(recipe()).schedule().water_flow_m2_per_s();
  const double perimeter = 2 * (1.32 + 0.57);
  EXPECT_NEAR(flow.value(0) * perimeter, 25 * per_hour, 1e-5 * 25 * per_hour);
  EXPECT_NEAR(flow.value(1) * perimeter, 45 * per_hour, 1e-5 * 45 * per_hour);
  EXPECT_THAT(new_case(recipe()).summary, HasSubstr("25 -> 45 m3/h = 110.2 -> 198.4 l/min/m"));
}

TEST(NewCase, WaterPerMetreStaysAsItIs) {
  SlabRecipe one = recipe();
  one.water = "90..180 l/min/m";
  const v1::Curve flow = made(one).schedule().water_flow_m2_per_s();
  EXPECT_NEAR(flow.value(0), 1.5e-3, 1e-9);
  EXPECT_NEAR(flow.value(1), 3.0e-3, 1e-9);
}

TEST(NewCase, SidesInEitherOrderAndAlloysInAnyCase) {
  SlabRecipe one = recipe();
  one.slab = "570x1320 mm";
  one.alloy = "AA5182";
  const v1::Case c = made(one);
  EXPECT_DOUBLE_EQ(c.section().half_width_m(), 0.66);
  EXPECT_DOUBLE_EQ(c.section().half_thickness_m().value(0), 0.285);
  EXPECT_EQ(c.alloy().card(), "aa5182");
}

TEST(NewCase, ABilletIsRound) {
  SlabRecipe one{.slab = "", .alloy = "AA6063", .speed = "80..120mm/min", .water = "5m3/h"};
  one.billet = "203mm";
  const v1::Case c = made(one);
  EXPECT_DOUBLE_EQ(c.section().half_width_m(), 0.1015);
  EXPECT_EQ(c.section().kind(), v1::Section::AXISYMMETRIC);
  EXPECT_NEAR(c.schedule().casting_speed_m_per_s().value(1), 120 * mm_per_min, 1e-9);
  EXPECT_NEAR(c.schedule().water_flow_m2_per_s().value(0) * 3.14159265 * 0.203, 5 * per_hour, 1e-7);
  EXPECT_THAT(new_case(one).summary, HasSubstr("billet 203 mm of aa6063, perimeter 0.6377 m"));
  one.billet = "round";
  EXPECT_THAT(new_case(one).faults, SizeIs(1));
}

TEST(NewCase, ACardOfOnesOwnIsAFile) {
  SlabRecipe one = recipe();
  one.alloy = "My-Alloy.toml";
  const NewCase made = new_case(one);
  EXPECT_THAT(made.faults, IsEmpty());
  EXPECT_THAT(made.text, HasSubstr("card = \"My-Alloy.toml\""));
}

TEST(NewCase, OneValueIsConstant) {
  SlabRecipe one = recipe();
  one.speed = "50 mm/min";
  EXPECT_EQ(made(one).schedule().casting_speed_m_per_s().value_size(), 1);
}

TEST(NewCase, MonitorsMoveWithTheSlab) {
  SlabRecipe one = recipe();
  one.slab = "1.6x0.5 m";
  const v1::Case c = made(one);
  ASSERT_EQ(c.monitor_size(), 5);
  EXPECT_DOUBLE_EQ(c.monitor(0).x_m(), 0.8);
  EXPECT_DOUBLE_EQ(c.monitor(0).y_m(), 0.25);
  EXPECT_DOUBLE_EQ(c.monitor(3).x_m(), 0.0);
  EXPECT_EQ(c.monitor(4).of_size(), 2) << "the mean of a plant has no place";
}

TEST(NewCase, EveryCardGivesACaseThatReads) {
  for (const std::string& card : case_file::alloy_names()) {
    SlabRecipe one = recipe();
    one.alloy = card;
    EXPECT_EQ(made(one).alloy().card(), card);
  }
}

TEST(NewCase, OfNothingButItsSizeIsTheShippedCase) {
  v1::Case c = made({.slab = "1320x570mm", .alloy = "", .speed = "", .water = ""});
  v1::Case shipped = shipped_case("start-3d");
  case_file::apply_defaults(c);
  c.clear_title();
  shipped.clear_title();
  EXPECT_EQ(c.DebugString(), shipped.DebugString());
}

/// Speed times thickness is that of the shipped slab, and so are the cast lengths of the ramp.
TEST(NewCase, SpeedFollowsTheThickness) {
  SlabRecipe one{.slab = "1320x760mm", .alloy = "aa3104", .speed = "", .water = ""};
  EXPECT_THAT(new_case(one).faults, SizeIs(1)) << "thicker than the rules hold for";
  one.slab = "1320x712.5mm";
  const v1::Curve speed = made(one).schedule().casting_speed_m_per_s();
  EXPECT_NEAR(speed.value(0), 0.8 * 45 * mm_per_min, 1e-9);
  EXPECT_NEAR(speed.value(1), 0.8 * 60 * mm_per_min, 1e-9);
  EXPECT_DOUBLE_EQ(speed.at(0), 75.0);   // 45 mm
  EXPECT_DOUBLE_EQ(speed.at(1), 250.0);  // and 122.5 mm more
}

TEST(NewCase, AThinSlabIsCastNoFaster) {
  const SlabRecipe thin{.slab = "1320x400mm", .alloy = "aa5182", .speed = "", .water = ""};
  const v1::Curve speed = made(thin).schedule().casting_speed_m_per_s();
  EXPECT_NEAR(speed.value(0), 38 * mm_per_min, 1e-9);
  EXPECT_NEAR(speed.value(1), 50 * mm_per_min, 1e-9);
  EXPECT_DOUBLE_EQ(speed.at(1), 200.0);
}

TEST(NewCase, ARampHasTheCastLengthsOfTheShippedOne) {
  SlabRecipe one{.slab = "1320x570mm", .alloy = "aa3104", .speed = "30..80mm/min", .water = ""};
  const auto schedule = made(one).schedule();
  EXPECT_DOUBLE_EQ(schedule.casting_speed_m_per_s().at(0), 90.0);
  EXPECT_DOUBLE_EQ(schedule.casting_speed_m_per_s().at(1), 224.0);  // 122.5 mm at 55 mm/min
  EXPECT_DOUBLE_EQ(schedule.water_flow_m2_per_s().at(1), 224.0);
}

/// The last water carries speed times area per perimeter: 57 mm/min over 1.32 / 5.6 m against 60
/// over 0.7524 / 3.78.
TEST(NewCase, WaterFollowsTheHeat) {
  const SlabRecipe wide{.slab = "2200x600mm", .alloy = "aa3104", .speed = "", .water = ""};
  const v1::Curve flow = made(wide).schedule().water_flow_m2_per_s();
  EXPECT_NEAR(flow.value(0), 1.5e-3, 1e-9);
  EXPECT_NEAR(flow.value(1), 203e-3 / 60, 1e-9) << 180 * 0.95 * (1.32 / 5.6) / (0.7524 / 3.78);
  EXPECT_THAT(new_case(wide).summary, HasSubstr("43 -> 57 mm/min"));
}

/// The first water falls with the heat, too, to 60 l/min/m at least.
TEST(NewCase, AThinSlabHasLessFirstWater) {
  SlabRecipe thin{.slab = "1060x420mm", .alloy = "aa5182", .speed = "", .water = ""};
  const v1::Curve flow = made(thin).schedule().water_flow_m2_per_s();
  EXPECT_NEAR(flow.value(0), 68e-3 / 60, 1e-9) << 90 * (0.4452 / 2.96) / (0.7524 / 3.78);
  EXPECT_NEAR(flow.value(1), 150e-3 / 60, 1e-9);
  thin.slab = "500x200mm";
  EXPECT_NEAR(made(thin).schedule().water_flow_m2_per_s().value(0), 60e-3 / 60, 1e-9);
}

TEST(NewCase, SizesBeyondTheRulesAreRefused) {
  for (const char* size : {"2700x600mm", "390x300mm", "1000x190mm", "1320x800mm"}) {
    const NewCase made = new_case({.slab = size, .alloy = "", .speed = "", .water = ""});
    ASSERT_THAT(made.faults, SizeIs(1)) << size;
    EXPECT_THAT(made.faults[0], HasSubstr("mm; the rules of `dccast new` hold from")) << size;
  }
  SlabRecipe billet;
  billet.billet = "600mm";
  EXPECT_THAT(new_case(billet).faults, SizeIs(1));
}

TEST(NewCase, SaysOfEveryFigureWhereItComesFrom) {
  const std::string text = new_case(recipe()).text;
  EXPECT_THAT(text, HasSubstr("dccast new --slab 1320x570mm --alloy aa5182 --speed 45..55mm/min "
                              "--water 25..45m3/h\n"));
  EXPECT_THAT(text, HasSubstr("start-3d-aa5182.toml"));
  EXPECT_THAT(text, HasSubstr("# [G] 25 -> 45 m3/h over a perimeter of 3.78 m"));
}

TEST(NewCase, AllFaultsComeAtOnce) {
  const NewCase made =
      new_case({.slab = "1320", .alloy = "aa5128", .speed = "45..55 mm", .water = "25..45 mm/min"});
  EXPECT_THAT(made.faults, SizeIs(4));
  EXPECT_THAT(made.faults[1], HasSubstr("did you mean aa5182?"));
  EXPECT_THAT(made.text, IsEmpty());
}

TEST(CastingSummary, IsAsAPlantPutsIt) {
  EXPECT_EQ(casting_summary(shipped_case("start-3d-aa5182")),
            "slab 1320 x 570 mm of aa5182, speed 38 -> 50 mm/min from 60 s to 200 s (over 102.7 "
            "mm), water 90 -> 180 l/min/m = 20.41 -> 40.82 m3/h");
}

TEST(CastingSummary, AddsUpBothFaces) {
  v1::Case c = shipped_case("start-3d");
  c.mutable_schedule()->mutable_narrow_water_flow_m2_per_s()->add_at(0.0);
  c.mutable_schedule()->mutable_narrow_water_flow_m2_per_s()->add_value(0.0);
  // 2 x 1.32 m x 90 l/min/m = 14.256 m3/h
  EXPECT_THAT(casting_summary(c), HasSubstr("= 14.26 -> 28.51 m3/h"));
}

TEST(CastingSummary, KnowsSectionsBilletsAndCastLengths) {
  EXPECT_THAT(casting_summary(shipped_case("start-2d-thickness")),
              testing::StartsWith("section through 560 mm of paper, speed 40 -> 60 mm/min"));
  EXPECT_THAT(casting_summary(shipped_case("start-billet")), HasSubstr("mm diameter"));
  v1::Case c = shipped_case("start-3d");
  v1::Curve& speed = *c.mutable_schedule()->mutable_casting_speed_m_per_s();
  speed.set_abscissa(v1::CAST_LENGTH);
  speed.set_at(0, 0.05);
  speed.set_at(1, 0.35);
  EXPECT_THAT(casting_summary(c), HasSubstr("from 50 mm to 350 mm (over 300 mm)"));
}

/// The summary of the start through the thickness with one more lever.
std::string summary_with(const std::string& key, const std::string& value) {
  v1::Case c = shipped_case("start-2d-thickness");
  EXPECT_THAT(apply_changes(c, {change_of(key, value)}), IsEmpty());
  return casting_summary(c);
}

TEST(CastingSummary, FollowsTheLevers) {
  EXPECT_THAT(summary_with("schedule.casting_speed.scale", "0.5"),
              HasSubstr("speed 20 -> 30 mm/min from 60 s to 200 s (over 58.33 mm)"));
  EXPECT_THAT(summary_with("schedule.casting_speed.shift", "10 s"),
              HasSubstr("speed 40 -> 60 mm/min from 70 s to 210 s (over 116.7 mm)"));
  // 20 mm/min for the first 20 mm, which take as long as the constant part of the table.
  EXPECT_THAT(summary_with("schedule.casting_speed.scale", "0.5 until 20 mm"),
              HasSubstr("speed 20 -> 60 mm/min from 60 s to 200 s (over 116.7 mm)"));
  EXPECT_THAT(summary_with("schedule.water_flow.scale", "0.5"),
              HasSubstr("water 45 -> 90 l/min/m"));
  EXPECT_THAT(
      summary_with("schedule.hold", "90 s"),
      HasSubstr("speed 40 -> 60 mm/min from 60 s to 200 s (over 116.7 mm), water 90 -> 180"));
}

TEST(CastingSummary, NamesTheValuesAtWhichSpeedAndWaterTurn) {
  EXPECT_THAT(summary_with("schedule.casting_speed.scale", "0.8 from 20 mm until 30 mm"),
              HasSubstr("speed 40 -> 32 -> 60 mm/min from 30 s to 200 s"));
  EXPECT_THAT(summary_with("schedule.water_flow.scale", "0.8 from 20 mm until 30 mm"),
              HasSubstr("water 90 -> 72 -> 180 l/min/m"));
}

TEST(CastingSummary, NamesPulsesAndWaterThatIsTurnedOff) {
  v1::Case c = shipped_case("start-3d");
  v1::Water& water = *c.mutable_cooling()->mutable_water();
  water.set_pulse_period_s(4.0);
  water.set_pulse_share(0.5);
  water.set_pulse_end_s(30.0);
  EXPECT_THAT(casting_summary(c), HasSubstr("m3/h, pulsed 2 of 4 s until 30 s"));

  water.set_enabled(false);
  EXPECT_THAT(casting_summary(c), HasSubstr(", no water"));
}

}  // namespace
}  // namespace dccast::case_file
