#include "core/casting/forecast.hpp"

#include <algorithm>
#include <utility>

#include "core/base/errors.hpp"
#include "core/casting/case/casting_schedule.hpp"
#include "core/casting/slab_run.hpp"
#include "core/mesh/plan_file.hpp"

namespace dccast::casting {

namespace {

// Resolution that gives the shell at the mould exit to a few millimetres.
constexpr int columns = 14;
constexpr int rows = 10;
constexpr int growth_rows = 20;
constexpr int steps = 70;

/// The thickness section of a quarter slab, in the middle of the wide face.
void take_thickness_section(Case& c) {
  c.section.kind = mesh::SectionKind::plane_strain;
  c.section.file.clear();
  c.section.half_width = c.section.half_thickness(0.0);
  c.section.heat_cells = {};
  c.cooling.bottom_block.profile_x = c.cooling.bottom_block.profile_y = {};
  c.cooling.narrow_water.reset();
  std::erase_if(c.cooling.zones,
                [](const thermal::SideZone& zone) { return zone.face == thermal::Face::narrow; });
  for (thermal::SideZone& zone : c.cooling.zones) zone.face.reset();
}

/// The heat problem of the case, on a coarse mesh with few steps.
Case coarse(Case c) {
  const Course course = course_of(c);
  mesh::SectionSpec& s = c.section;
  if (s.kind == mesh::SectionKind::quarter_slab) take_thickness_section(c);

  s.element = mesh::ElementKind::q1;
  s.refinement = 1;
  s.columns = columns;
  s.rows = rows;
  s.side_cell = std::min(5e-3, s.half_width / columns);
  s.bottom_cell = s.initial_depth / rows;
  s.growth_cell = std::clamp((course.depth - s.initial_depth) / growth_rows, 2e-3, s.initial_depth);

  c.figure_errors.clear();  // they are of the case's own mesh and steps
  c.mechanics.enabled = false;
  c.monitors.clear();

  c.thermal.tolerance = 1e-6;
  c.time.step = Curve((course.end - course.begin) / steps);
  c.time.minimum_step = c.time.step(0.0) / 64.0;
  return c;
}

}  // namespace

std::vector<results::Finding> forecast(const Case& c) {
  if (mesh::has_mesh_file(c.section) || !c.thermal.file.empty()) return {};

  SlabRun<2> run(coarse(c));
  try {
    while (!run.finished()) run.advance();
  } catch (const SolveFailed&) {
    // The findings up to that time are still a valid forecast.
  }

  std::vector<results::Finding> found;
  for (results::Finding finding : run.findings()) {
    if (!finding.time) continue;        // of the coarse case itself
    if (finding.key.empty()) continue;  // a check of the coarse run, not of the casting
    finding.message = "Forecast by heat alone on a coarse mesh: " + finding.message;
    found.push_back(std::move(finding));
  }
  return found;
}

}  // namespace dccast::casting
