#pragma once

#include "core/material/alloy_card.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "core/thermal/cooling_spec.hpp"
#include "tests/support/print_kinds.hpp"

/// The casting the heat tests share: the paper's alloy, mould, air gap, water and block.
namespace dccast::thermal::testing {

inline material::AlloyCard casting_alloy() {
  material::AlloyCard card;
  card.solidus = 620.0;
  card.liquidus = 649.0;
  card.latent_heat = 395e3;
  card.density = {Abscissa::temperature, {0, 620, 649}, {2700, 2557.4, 2360}};
  card.specific_heat = Curve(1050.0);
  card.conductivity = {Abscissa::temperature, {620, 649}, {200, 90}};
  card.melt_conductivity_factor = {Abscissa::liquid_fraction, {0.3, 0.8}, {1.0, 3.0}};
  return card;
}

inline material::AlloyCard pure_metal() {
  material::AlloyCard card;
  card.solidus = card.liquidus = 660.0;
  card.latent_heat = 397e3;
  card.density = Curve(2600.0);
  card.specific_heat = {Abscissa::temperature, {20, 660}, {900, 1150}};
  card.conductivity = Curve(210.0);
  card.melt_conductivity_factor = {Abscissa::liquid_fraction, {0, 1}, {1.0, 95.0 / 210.0}};
  return card;
}

/// Constants of docs/water.md.
inline Wetting wetting() {
  return {.flow_exponent = 1.0 / 3.0,
          .falling_film_share = 0.6,
          .jet_length = 0.02,
          .rewetting_saturated = 250.0,
          .rewetting_rise = 250.0,
          .rewetting_limit = 600.0,
          .rewetting_width = 50.0,
          .lag = 2.0,
          .jet_film_coefficient = 2000.0,
          .film_coefficient = 400.0,
          .throw_off_length = 0.04,
          .least_flow = 5e-5,
          .evaporation_from = 80.0};
}

/// Jet and film of a start, of no temperature yet.
inline Water water() {
  Water water;
  water.enabled = true;
  water.from = 0.065;
  water.critical_heat_flux = 4e6;
  water.pulse_share = 0.5;
  return water;
}

inline CoolingSpec casting_cooling() {
  CoolingSpec cooling;
  cooling.zones.resize(2);
  cooling.zones[0].to = 0.03;
  cooling.zones[0].liquid_coefficient = Curve(2000.0);
  cooling.zones[0].solid_coefficient = Curve(150.0);
  cooling.zones[1].from = 0.03;
  cooling.zones[1].to = 0.065;
  cooling.zones[1].liquid_coefficient = Curve(150.0);
  cooling.zones[1].solid_coefficient = Curve(150.0);
  cooling.water = water();
  cooling.water.temperature = Curve(25.0);
  cooling.dry_coefficient = 20.0;
  cooling.ambient_temperature = 25.0;
  cooling.top = Top::held;
  cooling.bottom_block.contact_coefficient = {Abscissa::time, {10, 40}, {2000, 500}};
  cooling.bottom_block.gap_coefficient = {Abscissa::gap, {0.2e-3, 5e-3, 5.5e-3}, {100, 100, 1000}};
  cooling.bottom_block.temperature = Curve(80.0);
  return cooling;
}

inline mesh::SectionSpec casting_section(mesh::ElementKind element) {
  mesh::SectionSpec section;
  section.half_width = 0.28;
  section.initial_depth = 0.10;
  section.element = element;
  section.columns = 30;
  section.rows = 22;
  section.side_cell = section.bottom_cell = 3e-3;
  section.growth_cell = 0.006;
  return section;
}

}  // namespace dccast::thermal::testing
