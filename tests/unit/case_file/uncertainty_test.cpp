#include "proto/case_file/uncertainty.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/schema.hpp"
#include "proto/case_file/shipped.hpp"
#include "tests/unit/case_file/shipped_case.hpp"

namespace dccast::case_file {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

v1::Case completed_with_ranges(v1::Case description) {
  apply_defaults(description);
  complete_alloy(alloy_card(description.alloy().card()).alloy, *description.mutable_alloy());
  return description;
}

v1::Case uncertain_case(const std::string& name) {
  v1::Case description;
  for (const auto& shipped : shipped::case_templates())
    if (shipped.name == name) read_text(shipped.text, name, description);
  return completed_with_ranges(description);
}

void add_range(v1::Case& description, const std::string& key, const std::string& range) {
  v1::KeyRange& line = *description.add_uncertainty();
  line.set_key(key);
  line.set_range(range);
}

std::string first_fault(const std::string& key, const std::string& range) {
  v1::Case description = uncertain_case("start-2d-thickness");
  description.clear_uncertainty();
  add_range(description, key, range);
  const auto faults = uncertainty_faults(description);
  return faults.empty() ? "" : describe(faults.front(), {});
}

const UncertainKey* found(const std::vector<UncertainKey>& keys, const std::string& key) {
  const auto at = std::ranges::find(keys, key, &UncertainKey::key);
  return at == keys.end() ? nullptr : &*at;
}

void expect_range(const std::string& text, const Range& expected) {
  const auto range = parse_range(text);
  ASSERT_TRUE(range) << text;
  EXPECT_EQ(range->suffix, expected.suffix) << text;
  EXPECT_EQ(range->low, expected.low) << text;
  EXPECT_EQ(range->high, expected.high) << text;
}

TEST(Range, HasFourForms) {
  expect_range("± 10 %", {".scale", "0.9", "1.1"});
  expect_range("+- 5 K", {".offset", "-5 K", "5 K"});
  expect_range("200..300 degC", {"", "200 degC", "300 degC"});
  expect_range("0.85 .. 1", {"", "0.85", "1"});
  expect_range("0.5..2 times", {".scale", "0.5", "2"});
}

TEST(Range, IsNothingElse) {
  for (const char* text : {"", "10 %", "± 0 %", "± 100 %", "2..1", "300..200 degC", "1..", "a..b",
                           "-1..2 times", "1 m..2 times", "± nan K", "1e999..2"})
    EXPECT_FALSE(parse_range(text)) << text;
}

TEST(Uncertainty, IsReadAndWrittenAsLines) {
  const std::string text = "[uncertainty]\n\"alloy.specific_heat\" = \"± 3 %\"\n";
  v1::Case read;
  EXPECT_EQ(read_text(text, "case", read).faults.front().field(), "section.half_width");
  ASSERT_EQ(read.uncertainty_size(), 1);
  EXPECT_EQ(read.uncertainty(0).key(), "alloy.specific_heat");
  EXPECT_THAT(to_toml(read), HasSubstr("[uncertainty]\n\"alloy.specific_heat\" = \"± 3 %\""));
  EXPECT_EQ(key_values(read).front().first, "uncertainty.alloy.specific_heat");
}

TEST(Uncertainty, FaultsOfAFileNameTheLine) {
  v1::Case read;
  const auto outcome =
      read_text("[uncertainty]\n\"alloy.specific_heat\" = \"3 %\"\nalloy.latent_heat = \"± 3 %\"\n",
                "case", read);
  std::string all;
  for (const v1::Fault& fault : outcome.faults) all += describe(fault, outcome.source) + "\n";
  EXPECT_THAT(all, HasSubstr("case:2:25: uncertainty.alloy.specific_heat = \"3 %\": is no range"));
  EXPECT_THAT(all, HasSubstr("put the key in quotes"));
}

TEST(Uncertainty, IsHeldAgainstTheCase) {
  EXPECT_EQ(first_fault("alloy.specific_heat", "± 3 %"), "");
  EXPECT_EQ(first_fault("schedule.casting_temperature", "± 5 K"), "");
  EXPECT_EQ(first_fault("alloy.melt_conductivity_factor[1]", "1..10"), "");
  EXPECT_EQ(first_fault("cooling.water.wetting.lag", "1..4 s"), "");
  EXPECT_THAT(first_fault("alloy.specific_heet", "± 3 %"),
              HasSubstr("uncertainty.alloy.specific_heet = ± 3 %: at 0.97: unknown key"));
  EXPECT_THAT(first_fault("schedule.casting_temperature", "± 5 mm"), HasSubstr("of another kind"));
  EXPECT_THAT(first_fault("alloy.density", "2600..2700 kg/m3"),
              HasSubstr("table of several points"));
  EXPECT_THAT(first_fault("alloy.solid_density", "2600..2700 kg/m3"),
              HasSubstr("names a key that has no value, neither in the case nor in its card"));
  EXPECT_THAT(first_fault("alloy.solidus_density", "1..2"), HasSubstr("unknown key"));
  EXPECT_THAT(first_fault("cooling.narrow_water.temperature", "20..30 degC"),
              HasSubstr("has no value"));
  EXPECT_THAT(first_fault("alloy.melt_conductivity_factor[7]", "1..10"),
              HasSubstr("no value here"));
  EXPECT_THAT(first_fault("cooling.water.wetting.lag", "3..4 s"),
              HasSubstr("does not hold the value of the case, 2 s; permitted: a range around the "
                        "value; widen it, or give it relative to the value, as \"± 10 %\"; or take "
                        "back the change of cooling.water.wetting.lag"));
  EXPECT_THAT(first_fault("alloy.poisson_ratio", "± 50 %"), HasSubstr("permitted: -0.9 to 0.4999"));
  EXPECT_THAT(first_fault("time.end", "± 5 %"), "");
  EXPECT_THAT(first_fault("quality", "0..1"), HasSubstr("unknown choice"));
  EXPECT_THAT(first_fault("title", "± 5 %"), HasSubstr("unknown key"));
}

/// "20..30 degC" says nothing of water that is 10 K warmer; "± 3 K" goes with the metal.
TEST(Uncertainty, RangesOfAValueGoWhereItIsMoved) {
  v1::Case description = shipped_case("start-3d-aa3104");
  const auto has_range = [&](const std::string& key) {
    return std::ranges::any_of(description.uncertainty(),
                               [&](const v1::KeyRange& range) { return range.key() == key; });
  };
  ASSERT_TRUE(has_range("cooling.water.temperature"));
  ASSERT_TRUE(has_range("alloy.melt_conductivity_factor[1]"));

  ASSERT_THAT(
      apply_changes(description, {change_of("cooling.water.temperature.offset", "10 K"),
                                  change_of("cooling.bottom_block.temperature.offset", "100 K"),
                                  change_of("cooling.bottom_block.wet_coefficient.scale", "3"),
                                  change_of("alloy.melt_conductivity_factor", "2"),
                                  change_of("schedule.casting_temperature.offset", "10 K")}),
      IsEmpty());
  EXPECT_FALSE(has_range("cooling.water.temperature"));
  EXPECT_FALSE(has_range("alloy.melt_conductivity_factor[1]"));
  EXPECT_TRUE(has_range("schedule.casting_temperature"));
  apply_quality(description);
  apply_defaults(description);
  EXPECT_THAT(uncertainty_faults(description), IsEmpty());
}

TEST(Uncertainty, OfCaseCardAndDefaultsAreOneList) {
  v1::Case description = uncertain_case("start-3d-aa5182");
  const auto keys = uncertain_keys(description);
  ASSERT_NE(found(keys, "alloy.reference_creep.stress"), nullptr);
  EXPECT_EQ(found(keys, "alloy.reference_creep.stress")->origin, "card");
  EXPECT_EQ(found(keys, "cooling.water.wetting.lag")->origin, "default");
  EXPECT_EQ(found(keys, "schedule.casting_temperature")->change(),
            "schedule.casting_temperature.offset");
  EXPECT_EQ(found(keys, "cooling.narrow_water.wetting.lag"), nullptr);
  add_range(description, "alloy.reference_creep.stress", "14..16 MPa");
  EXPECT_EQ(found(uncertain_keys(description), "alloy.reference_creep.stress")->range,
            "14..16 MPa");
}

TEST(Uncertainty, OfACardOrDefaultDoesNotHoldForAValueOfTheCase) {
  v1::Case description;
  apply_changes(
      description,
      {*parse_change("alloy.card=aa5182"), *parse_change("alloy.latent_heat=387 kJ/kg"),
       *parse_change("cooling.water.wetting.lag=1 s"), *parse_change("cooling.top=insulated")});
  const auto keys = uncertain_keys(completed_with_ranges(description));
  EXPECT_EQ(found(keys, "alloy.latent_heat"), nullptr);
  EXPECT_EQ(found(keys, "cooling.water.wetting.lag"), nullptr);
  EXPECT_EQ(found(keys, "cooling.level_coefficient"), nullptr);
  EXPECT_NE(found(keys, "alloy.specific_heat"), nullptr);
  EXPECT_NE(found(keys, "cooling.water.wetting.flow_exponent"), nullptr);
}

TEST(Uncertainty, OfTheCaseDoesNotHoldForAValueThatAChangeGives) {
  v1::Case description = uncertain_case("start-2d-thickness");
  description.clear_uncertainty();
  add_range(description, "schedule.hold", "50..70 s");
  v1::CaseChange change;
  change.set_key("schedule.hold");
  change.set_value("90 s");
  EXPECT_THAT(apply_changes(description, {change}), IsEmpty());
  EXPECT_EQ(found(uncertain_keys(description), "schedule.hold"), nullptr);
  EXPECT_THAT(uncertainty_faults(description), IsEmpty());
}

/// Every range of the schema, of a card and of a shipped case has ends that its key permits.
TEST(Uncertainty, OfTheShippedDataIsSound) {
  for (const std::string& name : alloy_names())
    EXPECT_THAT(uncertainty_faults(alloy_card(name).alloy), IsEmpty()) << name;

  for (const auto& shipped : shipped::case_templates()) {
    v1::Case all = uncertain_case(shipped.name);
    const auto keys = uncertain_keys(all);
    all.clear_uncertainty();
    for (const UncertainKey& datum : keys) add_range(all, datum.key, datum.range);
    for (const v1::Fault& fault : uncertainty_faults(all))
      ADD_FAILURE() << shipped.name << ": " << describe(fault, {});
    if (shipped.name.starts_with("start")) {
      EXPECT_GE(keys.size(), 15u) << shipped.name;
    }
  }
}

TEST(Changes, ScaleOffsetAndPointsChangeWhatIsThere) {
  v1::Case description = uncertain_case("start-2d-thickness");
  const double before = description.alloy().density_kg_per_m3().value(1);
  const auto faults =
      apply_changes(description, {*parse_change("alloy.density.scale=1.02"),
                                  *parse_change("schedule.hold.offset=5 s"),
                                  *parse_change("schedule.casting_temperature.offset=-3 K"),
                                  *parse_change("alloy.melt_conductivity_factor[1]=4")});
  EXPECT_THAT(faults, IsEmpty());
  EXPECT_DOUBLE_EQ(description.alloy().density_kg_per_m3().value(1), 1.02 * before);
  EXPECT_DOUBLE_EQ(description.schedule().hold_s(), 65.0);
  EXPECT_DOUBLE_EQ(description.schedule().casting_temperature_c().value(0), 677.0);
  EXPECT_DOUBLE_EQ(description.alloy().melt_conductivity_factor().value(1), 4.0);
  EXPECT_DOUBLE_EQ(description.alloy().melt_conductivity_factor().value(0), 1.0);
  EXPECT_EQ(number_at(description, "alloy.melt_conductivity_factor[1]"), 4.0);
  EXPECT_EQ(number_at(description, "alloy.density.scale"), 1.0);
  EXPECT_EQ(number_at(description, "schedule.casting_temperature.offset"), 0.0);
}

}  // namespace
}  // namespace dccast::case_file
