// An alloy card with a gap: each key of each shipped card is taken away, and the check of the case
// names it, or the metal computes.
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "core/casting/case/case_check.hpp"
#include "core/material/mechanical_properties.hpp"
#include "core/material/thermal_properties.hpp"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/schema.hpp"
#include "proto/case_file/shipped.hpp"
#include "server/translate/translate.hpp"

namespace dccast::translate {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// A key of a card: its field, or the table of the card and the field within it.
using KeyPath = std::vector<const FieldDescriptor*>;

std::string name_of(const KeyPath& path) {
  std::string name = "alloy";
  for (const FieldDescriptor* field : path) name += "." + case_file::toml_key(*field);
  return name;
}

/// Keys that a card has, with those of its tables and the tables themselves.
std::vector<KeyPath> keys_of(const Message& card) {
  std::vector<KeyPath> keys;
  std::vector<const FieldDescriptor*> given;
  card.GetReflection()->ListFields(card, &given);

  for (const FieldDescriptor* field : given) {
    keys.push_back({field});
    if (!case_file::is_table(*field) || field->is_repeated()) continue;
    std::vector<const FieldDescriptor*> within;
    const Message& table = card.GetReflection()->GetMessage(card, field);
    table.GetReflection()->ListFields(table, &within);
    for (const FieldDescriptor* each : within) keys.push_back({field, each});
  }
  return keys;
}

v1::Alloy without(const v1::Alloy& card, const KeyPath& path) {
  v1::Alloy changed = card;
  Message* table = &changed;
  if (path.size() == 2) table = changed.GetReflection()->MutableMessage(&changed, path[0]);
  table->GetReflection()->ClearField(table, path.back());
  return changed;
}

/// A shipped start with an alloy of its own, complete as the server completes it.
casting::Case case_with(const v1::Alloy& card, bool mechanics) {
  v1::Case description;
  const auto* const start = shipped::find(shipped::case_templates(), "start-2d-thickness");
  EXPECT_TRUE(case_file::read_text(start->text, "start.toml", description).ok());
  description.clear_alloy();
  description.mutable_mechanics()->set_enabled(mechanics);
  case_file::apply_defaults(description);
  case_file::complete_alloy(card, *description.mutable_alloy());
  return to_core(description, {});
}

/// Keys without which a card is complete: the schema says what holds then.
const std::set<std::string> may_be_absent{"alloy.card",
                                          "alloy.description",
                                          "alloy.provenance",
                                          "alloy.uncertainty",
                                          "alloy.melt_conductivity_factor",
                                          "alloy.melt_stirring",
                                          "alloy.liquid_fraction",
                                          "alloy.shell_solid_fraction",
                                          "alloy.coalescence_solid_fraction",
                                          "alloy.mush_strength_decay",
                                          "alloy.unfed_strain_share",
                                          "alloy.hot_tear_start_solid_fraction",
                                          "alloy.hot_tear_end_solid_fraction",
                                          "alloy.arm_spacing",
                                          "alloy.cell_mass",
                                          "alloy.cold_strength",
                                          "alloy.cold_strength.hardening"};

/// Keys that heat alone does not need.
bool is_mechanical(const std::string& name) {
  return name.starts_with("alloy.young_modulus") || name.starts_with("alloy.poisson_ratio") ||
         name.starts_with("alloy.reference_creep") || name.starts_with("alloy.norton_hoff") ||
         name.starts_with("alloy.cold_strength");
}

bool names(const Faults& faults, const std::string& key) {
  return std::ranges::any_of(faults.list(), [&](const Fault& fault) {
    return fault.field == key || fault.permitted.find(key) != std::string::npos;
  });
}

/// Expects that every law of the metal gives a number that can be right.
void expect_a_metal(const casting::Case& c, const std::string& name) {
  const material::ThermalProperties heat(c.alloy);
  EXPECT_GT(heat.solidification_enthalpy(), 5e8) << name;  // [J/m3] 200 J/g or more
  for (const double t : {20.0, 400.0, 560.0, 640.0, 700.0}) {
    EXPECT_GT(heat.enthalpy_derivative(t), 1e6) << name << " at " << t;
    EXPECT_GT(heat.conductivity(t), 10.0) << name << " at " << t;
  }
  if (!c.mechanics.enabled) return;

  const material::MechanicalProperties metal(c.alloy);
  for (const double t : {20.0, 400.0, 560.0}) {
    EXPECT_GT(metal.bulk_modulus(t), 1e9) << name << " at " << t;
    EXPECT_GT(metal.creep_factors(t).deviatoric, 0.0) << name << " at " << t;
    EXPECT_TRUE(std::isfinite(metal.creep_factors(t).deviatoric)) << name << " at " << t;
  }
  const double contraction = metal.thermal_stretch(c.alloy.coherency) - metal.thermal_stretch(20.0);
  EXPECT_GT(contraction, 0.01) << name;
  EXPECT_LT(contraction, 0.05) << name;
}

class IncompleteCard : public ::testing::TestWithParam<bool> {};

TEST_P(IncompleteCard, IsAFaultThatNamesTheKeyOrComputes) {
  const bool mechanics = GetParam();
  for (const std::string& card_name : case_file::alloy_names()) {
    const v1::Alloy card = case_file::alloy_card(card_name).alloy;
    const Faults of_whole = casting::check(case_with(card, mechanics)).faults;
    if (mechanics && card_name == "al6cu") {  // its density of a benchmark rises as it melts
      EXPECT_TRUE(names(of_whole, "alloy.density")) << of_whole.summary();
      continue;
    }
    if (mechanics && card_name == "pure_aluminium") {  // it has no mush
      EXPECT_TRUE(names(of_whole, "alloy.solidus")) << of_whole.summary();
      continue;
    }
    ASSERT_TRUE(of_whole.empty()) << card_name << ": " << of_whole.summary();

    std::size_t needed = 0;
    for (const KeyPath& key : keys_of(card)) {
      const std::string name = name_of(key);
      const casting::Case c = case_with(without(card, key), mechanics);
      const Faults faults = casting::check(c).faults;

      const bool may_be = may_be_absent.contains(name) || (!mechanics && is_mechanical(name));
      EXPECT_EQ(faults.empty(), may_be)
          << card_name << " without " << name << ": " << faults.summary();
      if (faults.empty()) {
        expect_a_metal(c, card_name + " without " + name);
      } else {
        EXPECT_TRUE(names(faults, name))
            << card_name << " without " << name << ": " << faults.summary();
        EXPECT_EQ(faults.list().size(), 1u) << faults.summary();
      }
      needed += !faults.empty();
    }
    EXPECT_GE(needed, mechanics ? 13u : 6u) << card_name;
  }
}
INSTANTIATE_TEST_SUITE_P(Physics, IncompleteCard, ::testing::Bool(), [](const auto& physics) {
  return std::string(physics.param ? "WithMechanics" : "HeatAlone");
});

/// The figures of a card that does not exist: every gap at once, none of which ends the check.
TEST(IncompleteCardAtAll, NamesEveryGapAtOnce) {
  const Faults faults = casting::check(case_with(v1::Alloy(), true)).faults;
  for (const char* key :
       {"alloy.liquidus", "alloy.solidus", "alloy.latent_heat", "alloy.specific_heat",
        "alloy.young_modulus", "alloy.poisson_ratio", "alloy.reference_creep"})
    EXPECT_TRUE(names(faults, key)) << key << " is not in " << faults.summary();
  EXPECT_EQ(faults.summary().find("exchange"), std::string::npos);
}

/// A mass that is fed needs the density at coalescence, which is not there.
TEST(IncompleteCardAtAll, SurvivesAFedMassWithoutADensity) {
  v1::Alloy card = case_file::alloy_card("aa5182").alloy;
  card.set_cell_mass(v1::Alloy::FED);
  card.clear_solid_density_kg_per_m3();
  EXPECT_TRUE(names(casting::check(case_with(card, true)).faults, "alloy.solid_density"));
}

/// A constant density, given in any of its keys, contracts nothing.
TEST(ConstantDensity, IsAFaultWithMechanics) {
  const auto constant = [](v1::Curve& density, double value) {
    density.Clear();
    density.add_at(0.0);
    density.add_value(value);
  };
  const auto faults_of = [](const v1::Alloy& card, bool mechanics) {
    return casting::check(case_with(card, mechanics)).faults;
  };

  v1::Alloy whole = case_file::alloy_card("paper").alloy;
  constant(*whole.mutable_density_kg_per_m3(), 2650.0);
  EXPECT_TRUE(names(faults_of(whole, true), "alloy.density"));
  EXPECT_TRUE(faults_of(whole, false).empty()) << "heat alone contracts nothing";

  for (const bool mush : {true, false}) {
    v1::Alloy solid = case_file::alloy_card("aa5182").alloy;
    constant(*solid.mutable_solid_density_kg_per_m3(), 2650.0);
    if (!mush) solid.clear_coalescence_solid_fraction();
    const Faults faults = faults_of(solid, true);
    ASSERT_EQ(faults.list().size(), 1u) << faults.summary();
    EXPECT_EQ(faults.list()[0].field, "alloy.solid_density");
    EXPECT_NE(faults.list()[0].message.find("would contract nothing"), std::string::npos);
  }

  // The same over the whole solid, though not over the mush.
  v1::Alloy mush_only = case_file::alloy_card("paper").alloy;
  mush_only.mutable_density_kg_per_m3()->set_value(0, 2557.4);
  EXPECT_TRUE(names(faults_of(mush_only, true), "alloy.density"));
}

}  // namespace
}  // namespace dccast::translate
