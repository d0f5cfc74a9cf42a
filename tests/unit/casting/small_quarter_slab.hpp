#pragma once

#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting::testing {

/// A quarter slab of few cells, whose mould is open in two segments: three seconds of hold, two of
/// casting.
inline Case small_quarter_slab(mesh::ElementKind element = mesh::ElementKind::q1_bending) {
  Case c = small_casting(element);
  c.title = "a small quarter slab";
  c.section.kind = mesh::SectionKind::quarter_slab;
  c.section.half_thickness = {Abscissa::distance, {0.0, 0.12, 0.28}, {0.15, 0.149, 0.14}};
  c.section.initial_depth = 0.066;
  c.section.columns = 4;
  c.section.layers = 3;
  c.section.rows = 4;
  c.section.side_cell = 0.03;
  c.section.wide_side_cell = 0.02;
  c.section.growth_cell = 0.008;
  c.mechanics.options.tolerance = 1e-8;
  c.mechanics.options.kinematics = mechanics::Kinematics::corotational;
  c.time.end = 2.0;
  c.schedule.hold = 3.0;
  c.schedule.casting_speed = Curve(6e-3);  // a row is put in once
  c.time.step = Curve(0.25);
  c.monitors = {{"corner", 0.28, 0.14, 0.0}, {"centre", 0.0, 0.0, 0.0}, {"wide", 0.0, 0.15, 0.07}};
  c.output.frame_interval = 0.7;
  return c;
}

/// The same with a rounded corner of two cells along each face.
inline Case small_rounded_slab(mesh::ElementKind element = mesh::ElementKind::q1_bending) {
  Case c = small_quarter_slab(element);
  c.section.corner_radius = 0.06;
  c.monitors[0].y = 0.07;
  return c;
}

}  // namespace dccast::casting::testing
