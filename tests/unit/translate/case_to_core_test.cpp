#include "server/translate/translate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/casting/findings/rules.hpp"
#include "proto/case_file/case_file.hpp"
#include "tests/unit/case_file/shipped_case.hpp"

namespace dccast::translate {
namespace {

TEST(CurveToCore, KeepsPointsAndAbscissa) {
  v1::Curve curve;
  EXPECT_TRUE(to_core(curve).empty());
  curve.set_abscissa(v1::GAP);
  for (const double at : {1.0, 3.0}) curve.add_at(at);
  for (const double value : {10.0, 20.0}) curve.add_value(value);
  const Curve core = to_core(curve);
  EXPECT_EQ(core.abscissa(), Abscissa::gap);
  EXPECT_DOUBLE_EQ(core(2.0), 15.0);
}

TEST(CaseToCore, TakesTheKeysOfAQuarterSlab) {
  v1::Case from;
  from.mutable_section()->set_kind(v1::Section::QUARTER_SLAB);
  from.mutable_section()->mutable_half_thickness_m()->add_at(0.0);
  from.mutable_section()->mutable_half_thickness_m()->add_value(0.285);
  from.mutable_mesh()->set_layers(5);
  from.mutable_mesh()->set_wide_side_cell_m(0.01);
  from.mutable_mesh()->set_heat_cells_per_column(3);
  from.mutable_mesh()->set_heat_cells_per_layer(2);
  from.mutable_schedule()->mutable_narrow_water_flow_m2_per_s()->add_at(0.0);
  from.mutable_schedule()->mutable_narrow_water_flow_m2_per_s()->add_value(2e-3);
  from.mutable_cooling()->mutable_narrow_water()->set_from_m(0.07);
  from.mutable_cooling()->add_zone()->set_face(v1::SideZone::NARROW);
  from.mutable_cooling()->mutable_bottom_block()->mutable_profile_y_m()->add_at(0.0);
  from.mutable_cooling()->mutable_bottom_block()->mutable_profile_y_m()->add_value(0.0);
  v1::DrainHole& hole = *from.mutable_cooling()->mutable_bottom_block()->add_drain_hole();
  hole.set_x_m(0.1);
  hole.set_y_m(0.2);
  hole.set_diameter_m(0.03);
  from.mutable_mechanics()->set_hold(v1::Mechanics::PENALTY);
  from.mutable_mechanics()->set_mould_penalty_pa_per_m(1e11);
  from.mutable_coupling()->set_deformed_zones(true);
  from.add_monitor()->set_z_m(0.02);
  from.add_monitor();
  const casting::Case to = to_core(from, "");

  EXPECT_EQ(to.section.kind, mesh::SectionKind::quarter_slab);
  EXPECT_EQ(to.section.half_thickness(0.3), 0.285);
  EXPECT_EQ(to.section.layers, 5);
  EXPECT_EQ(to.section.wide_side_cell, 0.01);
  EXPECT_EQ(to.section.heat_cells.per_column, 3);
  EXPECT_EQ(to.section.heat_cells.per_layer, 2);
  EXPECT_EQ(to.schedule.narrow_water_flow(0.0), 2e-3);
  EXPECT_EQ(to.cooling.narrow_water.value().from, 0.07);
  EXPECT_EQ(to.cooling.zones.at(0).face, thermal::Face::narrow);
  EXPECT_TRUE(to.cooling.bottom_block.profile_x.empty());
  EXPECT_FALSE(to.cooling.bottom_block.profile_y.empty());
  const thermal::DrainHole& drilled = to.cooling.bottom_block.drain_holes.at(0);
  EXPECT_EQ(drilled.x, 0.1);
  EXPECT_EQ(drilled.y, 0.2);
  EXPECT_EQ(drilled.diameter, 0.03);
  EXPECT_EQ(to.mechanics.options.confinement_by, mechanics::Confinement::penalty);
  EXPECT_EQ(to.mechanics.options.confinement_stiffness, 1e11);
  EXPECT_TRUE(to.coupling.deformed_zones);
  EXPECT_EQ(to.monitors.at(0).z, 0.02);
  EXPECT_FALSE(to.monitors.at(1).z);
}

TEST(Kinematics, FollowTheSectionUnlessTheCaseSaysOtherwise) {
  const auto of = [](v1::Section::Kind kind, v1::Mechanics::Kinematics asked) {
    v1::Case from;
    from.mutable_section()->set_kind(kind);
    from.mutable_mechanics()->set_kinematics(asked);
    return to_core(from, "").mechanics.options.kinematics;
  };
  using mechanics::Kinematics;
  EXPECT_EQ(of(v1::Section::QUARTER_SLAB, {}), Kinematics::corotational);
  EXPECT_EQ(of(v1::Section::PLANE_STRAIN, {}), Kinematics::small_strain);
  EXPECT_EQ(of(v1::Section::QUARTER_SLAB, v1::Mechanics::SMALL_STRAIN), Kinematics::small_strain);
  EXPECT_EQ(of(v1::Section::PLANE_STRAIN, v1::Mechanics::COROTATIONAL), Kinematics::corotational);
}

v1::Case mush(double solidus, double liquidus) {
  v1::Case from;
  from.mutable_alloy()->set_solidus_c(solidus);
  from.mutable_alloy()->set_liquidus_c(liquidus);
  return from;
}

/// Of a case with faults, which a worker is shown all the same. Found by the fuzz target
/// case_check.
TEST(CaseToCore, AMushWithoutAFiniteWidthMixesNothing) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double liquidus : {infinity, std::nan(""), 650.0})
    for (const double kink : {600.0, std::nan(""), infinity}) {
      v1::Case from;
      v1::Alloy& alloy = *from.mutable_alloy();
      alloy.set_liquidus_c(liquidus);
      alloy.set_solidus_c(liquidus == 650.0 ? 600.0 : -infinity);
      alloy.set_liquid_density_kg_per_m3(2400.0);
      alloy.mutable_density_kg_per_m3()->add_at(0.0);
      alloy.mutable_density_kg_per_m3()->add_value(2700.0);
      v1::Curve& solid = *alloy.mutable_solid_density_kg_per_m3();
      for (const double at : {20.0, kink}) solid.add_at(at);
      for (const double value : {2700.0, 2600.0}) solid.add_value(value);
      const bool is_mixed = liquidus == 650.0 && kink == 600.0;
      EXPECT_EQ(to_core(from, "").alloy.density.constant(), !is_mixed) << liquidus << " " << kink;
    }
}

TEST(Coherency, IsATemperatureOrASolidFraction) {
  v1::Case from = mush(515.0, 637.0);
  EXPECT_FALSE(material::is_given(to_core(from, "").alloy.coherency))
      << "so that the check sees it";
  from.mutable_alloy()->set_coherency_solid_fraction(1.0);
  EXPECT_EQ(to_core(from, "").alloy.coherency, 515.0) << "to the last bit";
  from.mutable_alloy()->set_coherency_solid_fraction(0.75);
  EXPECT_DOUBLE_EQ(to_core(from, "").alloy.coherency, 545.5);
  from.mutable_alloy()->set_coherency_c(600.0);
  EXPECT_EQ(to_core(from, "").alloy.coherency, 600.0);
  EXPECT_EQ(to_core(from, "").coherency_solid_fraction, 0.75) << "so that the check sees both";
}

TEST(Coherency, FollowsTheCardsLiquidFraction) {
  v1::Case from = mush(500.0, 600.0);
  v1::Curve& fraction = *from.mutable_alloy()->mutable_liquid_fraction();
  fraction.set_abscissa(v1::TEMPERATURE);
  for (const double at : {500.0, 501.0, 550.0, 600.0}) fraction.add_at(at);
  for (const double value : {0.0, 0.2, 0.2, 1.0}) fraction.add_value(value);
  for (const auto& [solid, temperature] : {std::pair{1.0, 500.0}, std::pair{0.9, 500.5},
                                           std::pair{0.4, 575.0}, std::pair{0.0, 600.0}}) {
    from.mutable_alloy()->set_coherency_solid_fraction(solid);
    EXPECT_NEAR(to_core(from, "").alloy.coherency, temperature, 1e-9) << solid;
  }
}

TEST(CaseToCore, TakesEveryKindOfKey) {
  v1::Case from;
  from.set_title("t");
  from.mutable_section()->set_kind(v1::Section::AXISYMMETRIC);
  from.mutable_section()->set_half_width_m(0.25);
  from.mutable_mesh()->set_element(v1::Q1);
  from.mutable_mesh()->set_file("slab.msh");
  from.mutable_mesh()->set_growth(false);
  from.mutable_thermal()->set_file("t.h5");
  from.mutable_mechanics()->set_algorithm(v1::Mechanics::VNBM);
  from.mutable_mechanics()->set_liquid(v1::Mechanics::SOLID);
  from.mutable_mechanics()->mutable_parameters()->set_lambda_p_pa_s(3.0);
  from.mutable_cooling()->set_top(v1::Cooling::INSULATED);
  from.mutable_cooling()->add_zone()->set_to_m(0.04);
  from.mutable_limits()->set_maximum_steps(7);
  v1::Validity& validity = *from.mutable_validity();
  validity.set_when_lost(v1::Validity::CONTINUE);
  validity.set_maximum_rotation_rad(0.25);
  validity.set_maximum_slip_m(0.03);
  validity.set_minimum_shell_m(0.004);
  v1::Plausibility& plausibility = *from.mutable_plausibility();
  plausibility.set_minimum_superheat_k(7.0);
  plausibility.set_minimum_shell_m(0.006);
  plausibility.set_maximum_mush_strain(0.007);
  plausibility.set_maximum_sump_share(0.8);
  plausibility.set_greatest_curl_m(0.045);
  plausibility.set_reference_tear_rate_per_s(2e-4);
  plausibility.set_reference_tear_pressure_pa(9e4);
  auto* monitor = from.add_monitor();
  monitor->set_name("corner");
  monitor->set_x_m(0.25);
  const casting::Case to = to_core(from, "/folder");

  EXPECT_EQ(to.section.kind, mesh::SectionKind::axisymmetric);
  EXPECT_EQ(to.section.half_width, 0.25);
  EXPECT_EQ(to.section.element, mesh::ElementKind::q1);
  EXPECT_EQ(to.section.file, "/folder/slab.msh");
  EXPECT_FALSE(to.section.growth);
  EXPECT_FALSE(to.section.growth_cell);
  EXPECT_EQ(to.thermal.file, "/folder/t.h5");
  EXPECT_EQ(to.mechanics.options.algorithm, mechanics::Algorithm::vnbm);
  EXPECT_EQ(to.mechanics.options.liquid, mechanics::Liquid::solid);
  EXPECT_EQ(to.mechanics.options.parameters.lambda_p, 3.0);
  EXPECT_FALSE(to.mechanics.options.parameters.lambda_c);
  EXPECT_EQ(to.cooling.top, thermal::Top::insulated);
  EXPECT_EQ(to.cooling.zones.at(0).to, 0.04);
  EXPECT_EQ(to.limits.maximum_steps, 7);
  EXPECT_EQ(to.plausibility.minimum_superheat, 7.0);
  EXPECT_EQ(to.plausibility.minimum_shell, 0.006);
  EXPECT_EQ(to.plausibility.maximum_mush_strain, 0.007);
  EXPECT_EQ(to.plausibility.maximum_sump_share, 0.8);
  EXPECT_EQ(to.plausibility.greatest_curl, 0.045);
  EXPECT_EQ(to.plausibility.reference_tear_rate, 2e-4);
  EXPECT_EQ(to.plausibility.reference_tear_pressure, 9e4);
  EXPECT_FALSE(to.plausibility.least_curl);
  EXPECT_EQ(to.validity.when_lost, casting::WhenLost::go_on);
  EXPECT_EQ(to.validity.maximum_rotation, 0.25);
  EXPECT_EQ(to.validity.maximum_slip, 0.03);
  EXPECT_EQ(to.validity.minimum_shell, 0.004);
  EXPECT_EQ(to.monitors.at(0).name, "corner");
  EXPECT_NE(to.source_json.find("\"half_width_m\":0.25"), std::string::npos) << to.source_json;
}

TEST(CaseToCore, AnAlloyHasOneCreepLawAndACoherencyTemperature) {
  v1::Case from;
  from.mutable_alloy()->mutable_reference_creep()->set_stress_pa(1e6);
  auto to = to_core(from, "");
  EXPECT_EQ(std::get<material::ReferenceCreep>(to.alloy.creep).stress, 1e6);
  EXPECT_FALSE(material::is_given(std::get<material::ReferenceCreep>(to.alloy.creep).temperature));
  from.mutable_alloy()->set_coherency_c(600);
  from.mutable_alloy()->mutable_norton_hoff()->set_exponent(5);
  to = to_core(from, "");
  EXPECT_EQ(to.alloy.coherency, 600);
  EXPECT_EQ(std::get<material::NortonHoffConstants>(to.alloy.creep).exponent, 5);
}

TEST(CaseToCore, TakesFacesPulsesFactorsAndShifts) {
  v1::Case from;
  auto* zone = from.mutable_cooling()->add_zone();
  zone->set_face(v1::SideZone::NARROW);
  from.mutable_cooling()->add_zone()->set_face(v1::SideZone::EVERY);
  v1::Water& water = *from.mutable_cooling()->mutable_narrow_water();
  water.set_boiling_follows_flow(true);
  water.set_pulse_period_s(4.0);
  water.set_pulse_share(0.25);
  water.set_pulse_end_s(30.0);
  v1::Schedule& schedule = *from.mutable_schedule();
  schedule.mutable_narrow_water_flow_m2_per_s()->add_at(0.0);
  schedule.mutable_narrow_water_flow_m2_per_s()->add_value(2e-3);
  schedule.mutable_water_flow_factor()->add_at(0.0);
  schedule.mutable_water_flow_factor()->add_value(0.5);
  schedule.set_casting_speed_shift_s(3.0);
  schedule.set_water_flow_shift_s(-2.0);
  from.mutable_coupling()->set_deformed_zones(true);
  const casting::Case to = to_core(from, "");

  EXPECT_EQ(to.cooling.zones.at(0).face, thermal::Face::narrow);
  EXPECT_FALSE(to.cooling.zones.at(1).face);
  ASSERT_TRUE(to.cooling.narrow_water);
  EXPECT_TRUE(to.cooling.narrow_water->boiling_follows_flow);
  EXPECT_EQ(to.cooling.narrow_water->pulse_period, 4.0);
  EXPECT_EQ(to.cooling.narrow_water->pulse_share, 0.25);
  EXPECT_EQ(to.cooling.narrow_water->pulse_end, 30.0);
  EXPECT_FALSE(to.cooling.water.boiling_follows_flow);
  EXPECT_EQ(to.schedule.narrow_water_flow(0.0), 2e-3);
  EXPECT_EQ(to.schedule.water_flow_factor(0.0), 0.5);
  EXPECT_EQ(to.schedule.casting_speed_factor(0.0), 1.0);
  EXPECT_EQ(to.schedule.casting_speed_shift, 3.0);
  EXPECT_EQ(to.schedule.water_flow_shift, -2.0);
  EXPECT_TRUE(to.coupling.deformed_zones);
  EXPECT_FALSE(to_core(v1::Case(), "").cooling.narrow_water);
}

/// Core has no defaults: what it cannot do without is filled by those of the schema.
TEST(CaseToCore, DefaultsOfTheSchemaFillWhatCoreNeeds) {
  v1::Case complete;
  case_file::apply_defaults(complete);
  const casting::Case to = to_core(complete, "");
  const mechanics::Options& options = to.mechanics.options;
  EXPECT_TRUE(to.mechanics.enabled && options.contact && options.confinement);
  EXPECT_TRUE(to.cooling.water.enabled && to.section.growth && to.coupling.gap_feedback);
  for (const double needed : {to.thermal.tolerance,
                              double(to.thermal.maximum_iterations),
                              options.tolerance,
                              options.gravity,
                              options.confinement_stiffness,
                              options.parameters.gamma_p,
                              options.parameters.gamma_c,
                              options.parameters.relaxation,
                              to.time.minimum_step,
                              to.output.frame_interval,
                              to.checkpoint.every_seconds,
                              to.validity.maximum_rotation,
                              to.validity.maximum_slip,
                              to.plausibility.minimum_shell,
                              to.plausibility.minimum_meniscus,
                              to.alloy.hot_tears.end,
                              to.plausibility.maximum_sump_share,
                              double(to.limits.maximum_nodes),
                              double(to.limits.maximum_steps),
                              to.cooling.water.from,
                              to.cooling.water.critical_heat_flux,
                              to.cooling.water.pulse_share,
                              to.cooling.dry_coefficient})
    EXPECT_GT(needed, 0.0);
  EXPECT_EQ(to.section.refinement, 1);
  EXPECT_EQ(to.coupling.iterations, 1);

  // Hot tears are judged against figures that the user gives.
  EXPECT_FALSE(to.plausibility.maximum_mush_strain);
  EXPECT_FALSE(to.plausibility.reference_tear_rate);
  EXPECT_FALSE(to.plausibility.reference_tear_pressure);
}

/// A name that no rule has would be a band that nothing uses.
TEST(CaseToCore, EveryBandOfAFigureBelongsToARule) {
  v1::Case complete = case_file::shipped_case("start-3d-aa3104");
  case_file::apply_defaults(complete);
  const casting::Case start = to_core(complete, "");
  EXPECT_GE(start.figure_errors.size(), 9u);
  for (const auto& [figure, error] : start.figure_errors) {
    EXPECT_TRUE(std::ranges::any_of(casting::step_rules(), [&](const casting::StepRule& rule) {
      return rule.figure == figure;
    })) << figure;
    EXPECT_GE(error.below, 0.0);
    EXPECT_GT(error.above, 0.0);
  }
}

TEST(CaseToCore, TheWindowOfHotTearsEndsAtCoalescenceUnlessItIsGiven) {
  v1::Case complete;
  case_file::apply_defaults(complete);
  v1::Alloy& alloy = *complete.mutable_alloy();
  const auto end = [&] { return to_core(complete, "").alloy.hot_tears.end; };
  EXPECT_EQ(end(), 0.98);
  alloy.set_coalescence_solid_fraction(0.95);
  EXPECT_EQ(end(), 0.95);
  alloy.set_coalescence_solid_fraction(1.0);
  EXPECT_EQ(end(), 0.99) << "melt does not flow through metal without melt";
  alloy.set_hot_tear_end_solid_fraction(0.97);
  EXPECT_EQ(end(), 0.97);
}

}  // namespace
}  // namespace dccast::translate
