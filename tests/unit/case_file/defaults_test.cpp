#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "dccast/v1/config.pb.h"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"

namespace dccast::case_file {
namespace {

using testing::HasSubstr;

TEST(Defaults, FillEveryAbsentKeyOnce) {
  v1::Case message;
  message.mutable_section()->set_half_width_m(0.28);
  message.mutable_section()->set_initial_depth_m(0.1);
  message.mutable_mesh()->set_columns(7);
  message.add_monitor();
  apply_defaults(message);

  EXPECT_EQ(message.mesh().columns(), 7);
  EXPECT_EQ(message.mesh().rows(), 44);  // by quality
  EXPECT_EQ(message.section().kind(), v1::Section::PLANE_STRAIN);
  EXPECT_NEAR(message.schedule().casting_speed_m_per_s().value(0), 1e-3, 1e-15);
  EXPECT_EQ(message.cooling().bottom_block().gap_coefficient_w_per_m2_k().at_size(), 3);
  EXPECT_DOUBLE_EQ(message.mechanics().parameters().gamma_p_per_pa_s(), 1.25e-12);

  const std::string once = message.SerializeAsString();
  apply_defaults(message);
  EXPECT_EQ(message.SerializeAsString(), once);
}

/// The shell that exists when the mould is full is the first that can be free of stress.
TEST(Defaults, MechanicsStartAtTheEndOfFilling) {
  v1::Case filled;
  filled.mutable_schedule()->set_hold_s(70.0);
  filled.mutable_schedule()->set_filling_s(35.0);
  apply_defaults(filled);
  EXPECT_DOUBLE_EQ(filled.mechanics().start_s(), -35.0);

  v1::Case full, chosen = filled;
  apply_defaults(full);
  EXPECT_DOUBLE_EQ(full.mechanics().start_s(), 0.0);

  chosen.mutable_mechanics()->set_start_s(5.0);
  apply_defaults(chosen);
  EXPECT_DOUBLE_EQ(chosen.mechanics().start_s(), 5.0);
}

TEST(Defaults, OfTheDaemonPassItsChecks) {
  v1::DaemonConfig config;
  apply_defaults(config);
  EXPECT_TRUE(check_ranges(config).empty());
  EXPECT_DOUBLE_EQ(config.per_case().maximum_attachment_bytes(), 64e6);
  EXPECT_EQ(config.log().level(), "info");
}

TEST(Defaults, DoNotHideWhatTheAlloyCardSays) {
  v1::Case message;
  apply_defaults(message);
  EXPECT_EQ(message.alloy().card(), "paper");
  EXPECT_FALSE(message.alloy().has_melt_conductivity_factor());
  const AlloyCard card = alloy_card("paper");
  ASSERT_TRUE(card.ok());
  complete_alloy(card.alloy, *message.mutable_alloy());
  EXPECT_EQ(message.alloy().melt_conductivity_factor().value_size(), 2);
  EXPECT_DOUBLE_EQ(message.alloy().solidus_c(), 620.0);
  EXPECT_FALSE(message.alloy().has_reference_creep());
}

TEST(CompleteAlloy, TheCaseWinsOverTheCard) {
  v1::Alloy overrides;
  overrides.set_solidus_c(607.0);
  overrides.mutable_density_kg_per_m3()->add_at(0.0);
  overrides.mutable_density_kg_per_m3()->add_value(2700.0);
  overrides.mutable_norton_hoff()->set_exponent(5.0);
  complete_alloy(alloy_card("paper").alloy, overrides);
  EXPECT_DOUBLE_EQ(overrides.solidus_c(), 607.0);
  EXPECT_EQ(overrides.density_kg_per_m3().value_size(), 1)
      << "curves are replaced, not appended to";
  EXPECT_DOUBLE_EQ(overrides.norton_hoff().exponent(), 5.0);
  EXPECT_DOUBLE_EQ(overrides.norton_hoff().shear_limit_pa(), 15.72e6);
}

TEST(CompleteAlloy, AnotherCreepLawReplacesThatOfTheCard) {
  v1::Alloy overrides;
  overrides.mutable_reference_creep()->set_stress_pa(5e6);
  complete_alloy(alloy_card("paper").alloy, overrides);
  EXPECT_FALSE(overrides.has_norton_hoff());
}

/// One thing said in two ways.
TEST(CompleteAlloy, ACoherencyReplacesThatOfTheCardHoweverItIsSaid) {
  v1::Alloy overrides;
  overrides.set_coherency_solid_fraction(0.9);
  complete_alloy(alloy_card("paper").alloy, overrides);
  EXPECT_FALSE(overrides.has_coherency_c());

  v1::Alloy card = alloy_card("paper").alloy;
  card.clear_coherency_c();
  card.set_coherency_solid_fraction(0.9);
  v1::Alloy temperature;
  temperature.set_coherency_c(630.0);
  complete_alloy(card, temperature);
  EXPECT_FALSE(temperature.has_coherency_solid_fraction());

  v1::Alloy both;
  both.set_coherency_c(630.0);
  both.set_coherency_solid_fraction(0.9);
  complete_alloy(card, both);
  EXPECT_TRUE(both.has_coherency_c() && both.has_coherency_solid_fraction())
      << "a fault for the check";
}

TEST(CompleteAlloy, StirringOfTheCaseReplacesThatOfTheCardHoweverItIsSaid) {
  v1::Alloy by_size;
  by_size.set_melt_stirring(9.0);
  complete_alloy(alloy_card("paper").alloy, by_size);
  EXPECT_FALSE(by_size.has_melt_conductivity_factor());

  v1::Alloy table;
  table.mutable_melt_conductivity_factor()->add_at(0.0);
  table.mutable_melt_conductivity_factor()->add_value(2.0);
  complete_alloy(by_size, table);
  EXPECT_FALSE(table.has_melt_stirring());
}

TEST(AlloyCard, AnUnknownNameIsAFaultWithTheNearestOne) {
  const AlloyCard card = alloy_card("aa5128");
  ASSERT_EQ(card.faults.size(), 1u);
  EXPECT_THAT(card.faults[0].remedy(), HasSubstr("aa5182"));
  EXPECT_FALSE(alloy_card("../paper").ok());
  EXPECT_FALSE(alloy_card("").ok());
}

std::string ranges_of(const v1::Case& message) {
  std::string all;
  for (const v1::Fault& fault : check_ranges(message))
    all += fault.field() + ": " + fault.message() + "\n";
  return all;
}

v1::Case sound_defaults() {
  v1::Case message;
  message.mutable_section()->set_half_width_m(0.28);
  message.mutable_section()->set_initial_depth_m(0.1);
  message.mutable_time()->set_end_s(145.0);
  return message;
}

TEST(CheckRanges, FindsEverythingInAMessageFromTheWire) {
  EXPECT_EQ(ranges_of(sound_defaults()), "");

  v1::Case message = sound_defaults();
  message.mutable_section()->set_half_width_m(std::nan(""));
  message.mutable_section()->set_kind(static_cast<v1::Section::Kind>(77));
  message.mutable_time()->clear_end_s();
  message.add_monitor()->set_x_m(-1.0);
  auto& speed = *message.mutable_schedule()->mutable_casting_speed_m_per_s();
  speed.set_abscissa(v1::GAP);
  for (const double at : {0.0, 0.0}) speed.add_at(at);
  for (const double value : {1e-3, 7.0}) speed.add_value(value);
  message.mutable_schedule()->mutable_water_flow_m2_per_s()->add_at(1.0);
  message.mutable_schedule()->mutable_casting_temperature_c();
  const std::string all = ranges_of(message);
  for (const char* const expected :
       {"section.half_width: not a finite number", "section.kind: unknown choice",
        "time.end: required key is missing", "monitor[0].x: out of range",
        "monitor[0].name: required",
        "schedule.casting_speed: not a permitted abscissa of this table",
        "schedule.casting_speed[1]: must be larger", "schedule.casting_speed[1]: out of range",
        "schedule.water_flow: as many values", "schedule.casting_temperature: an empty table"})
    EXPECT_THAT(all, HasSubstr(expected));
}

/// Found by the fuzz target case_check: it was no fault, and the worker had no answer.
TEST(CheckRanges, AConstantNeedsNoAbscissaButOneThatThereIsNotIsAFault) {
  v1::Case message = sound_defaults();
  message.mutable_time()->mutable_step_s()->add_at(0.0);
  message.mutable_time()->mutable_step_s()->add_value(0.5);
  EXPECT_EQ(ranges_of(message), "");
  message.mutable_time()->mutable_step_s()->set_abscissa(static_cast<v1::Abscissa>(7));
  EXPECT_THAT(ranges_of(message), HasSubstr("time.step: not a permitted abscissa"));
}

TEST(CheckRanges, RefusesTwoLawsOfStirring) {
  v1::Case message = sound_defaults();
  message.mutable_alloy()->set_melt_stirring(9.0);
  EXPECT_EQ(ranges_of(message), "");

  message.mutable_alloy()->mutable_melt_conductivity_factor()->add_at(0.0);
  message.mutable_alloy()->mutable_melt_conductivity_factor()->add_value(2.0);
  EXPECT_THAT(ranges_of(message),
              HasSubstr("alloy.melt_stirring: alloy.melt_conductivity_factor is given, too"));
}

TEST(Defaults, OfACardThatIsCompletedTwiceAreThoseOfOnce) {
  v1::Alloy once;
  complete_alloy(alloy_card("aa5182").alloy, once);
  v1::Alloy twice = once;
  complete_alloy(alloy_card("aa5182").alloy, twice);
  EXPECT_EQ(twice.cold_strength().DebugString(), once.cold_strength().DebugString());
  EXPECT_GT(once.cold_strength().yield_stress_pa().value_size(), 0);
}

}  // namespace
}  // namespace dccast::case_file
