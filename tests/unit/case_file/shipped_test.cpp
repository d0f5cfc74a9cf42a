#include "proto/case_file/shipped.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast {
namespace {

TEST(Shipped, EveryCaseIsSound) {
  EXPECT_GE(shipped::case_templates().size(), 2u);

  for (const auto& shipped : shipped::case_templates()) {
    v1::Case message;
    const auto outcome = case_file::read_text(shipped.text, shipped.name + ".toml", message);
    for (const v1::Fault& fault : outcome.faults)
      ADD_FAILURE() << case_file::describe(fault, outcome.source);
    case_file::apply_defaults(message);
    const auto card = case_file::alloy_card(message.alloy().card());
    EXPECT_TRUE(card.ok());
    case_file::complete_alloy(card.alloy, *message.mutable_alloy());
    for (const v1::Fault& fault : case_file::check_ranges(message))
      ADD_FAILURE() << shipped.name << ": " << case_file::describe(fault, outcome.source);
    EXPECT_FALSE(message.title().empty());
    EXPECT_GE(message.monitor_size(), message.mechanics().enabled() ? 3 : 0);
  }
}

TEST(Shipped, EveryAlloyCardIsCompleteAndConsistent) {
  EXPECT_THAT(
      case_file::alloy_names(),
      testing::IsSupersetOf({"aa1050", "aa3104", "aa5182", "aa6063", "paper", "pure_aluminium"}));

  for (const std::string& name : case_file::alloy_names()) {
    const auto card = case_file::alloy_card(name);
    for (const v1::Fault& fault : card.faults) ADD_FAILURE() << fault.message();
    // Linear, 0.9 or the paper's where absent, or given in another way, see below.
    const std::set<std::string> may_be_absent{"liquid_fraction",
                                              "cell_mass",
                                              "melt_stirring",
                                              "shell_solid_fraction",
                                              "coherency_c",
                                              "coherency_solid_fraction",
                                              "coalescence_solid_fraction",
                                              "mush_strength_decay",
                                              "unfed_strain_share",
                                              "hot_tear_start_solid_fraction",
                                              "hot_tear_end_solid_fraction",
                                              "arm_spacing_m",
                                              "density_kg_per_m3",
                                              "solid_density_kg_per_m3",
                                              "liquid_density_kg_per_m3",
                                              "conductivity_w_per_m_k",
                                              "solid_conductivity_w_per_m_k",
                                              "liquid_conductivity_w_per_m_k"};
    const auto& descriptor = *v1::Alloy::descriptor();
    for (int i = 0; i < descriptor.field_count(); ++i)
      EXPECT_TRUE(case_file::is_table(*descriptor.field(i)) ||
                  case_file::is_present(card.alloy, *descriptor.field(i)) ||
                  may_be_absent.contains(descriptor.field(i)->name()))
          << name << " lacks " << descriptor.field(i)->name();
    const v1::Alloy& alloy = card.alloy;
    EXPECT_NE(alloy.has_coherency_c(), alloy.has_coherency_solid_fraction()) << name;
    EXPECT_NE(alloy.has_density_kg_per_m3(),
              alloy.has_solid_density_kg_per_m3() && alloy.has_liquid_density_kg_per_m3())
        << name;
    EXPECT_NE(alloy.has_conductivity_w_per_m_k(),
              alloy.has_solid_conductivity_w_per_m_k() && alloy.has_liquid_conductivity_w_per_m_k())
        << name;
    EXPECT_NE(card.alloy.has_norton_hoff(), card.alloy.has_reference_creep()) << name;
    EXPECT_LE(card.alloy.solidus_c(), card.alloy.liquidus_c()) << name;
  }
}

TEST(Shipped, PureAluminiumFollowsTheFormulasOfNist) {
  const v1::Alloy alloy = case_file::alloy_card("pure_aluminium").alloy;
  EXPECT_NEAR(alloy.liquidus_c() + 273.15, 933.47, 1e-9);
  const auto& heat = alloy.specific_heat_j_per_kg_k();
  for (int i = 0; i + 1 < heat.at_size(); ++i) {
    const double t = (heat.at(i) + 273.15) / 1000.0;
    const double molar =
        28.0892 - 5.414849 * t + 8.560423 * t * t + 3.42737 * t * t * t - 0.277375 / (t * t);
    EXPECT_NEAR(heat.value(i), molar / 0.02698, 0.06) << heat.at(i);
  }
  EXPECT_NEAR(heat.value(heat.value_size() - 1), 31.75104 / 0.02698, 0.06);
}

}  // namespace
}  // namespace dccast
