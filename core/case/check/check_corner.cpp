// The rounded corner of a quarter slab's mould.
#include <algorithm>

#include "core/case/check/checks.hpp"
#include "core/mesh/base.hpp"
#include "core/mesh/rounded_corner.hpp"

namespace dccast::casting {

namespace {

constexpr double round_off = 1e-9;  // [m]

/// Largest possible radius: limited by the symmetry planes and by the last break point of the
/// opening.
double largest_radius(const mesh::SectionSpec& s) {
  double last = 0.0;
  for (const double at : s.half_thickness.at())
    if (at < s.half_width - round_off) last = std::max(last, at);
  return std::min(s.half_width - last, s.half_thickness(s.half_width));
}

bool too_large(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  const double most = largest_radius(s);
  if (s.corner_radius <= most + round_off) return false;
  found.fault("section.corner_radius", with_unit(s.corner_radius, "m"),
              "reaches beyond the middle of the slab or the last break point of "
              "section.half_thickness",
              "at most " + with_unit(most, "m"), "choose a smaller radius");
  return true;
}

void misses_the_mesh(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  const auto cells = mesh::corner_cells(s);
  const bool enough = std::min(cells[0], cells[1]) >= mesh::fewest_corner_cells;
  if (enough && break_points_have_nodes(s)) return;
  if (enough) {
    found.fault("section.corner_radius", with_unit(s.corner_radius, "m"),
                "ends in the row of nodes of a break point of section.half_thickness",
                "an end with a row of nodes of its own",
                "use more mesh.columns, or move the break point away from the corner");
    return;
  }
  const double cell = std::max(s.side_cell, s.wide_side_cell);
  found.fault("section.corner_radius", with_unit(s.corner_radius, "m"),
              "holds too few cells for an arc: " + std::to_string(cells[0]) +
                  " along the wide face, " + std::to_string(cells[1]) + " along the narrow face",
              "2 cells or more along each, about " + with_unit(2.0 * cell, "m") +
                  " with these cells, or 0 m for a square corner",
              "choose a larger radius, or smaller mesh.side_cell and mesh.wide_side_cell");
}

}  // namespace

void check_corner(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  if (s.corner_radius <= 0.0) return;
  if (!s.file.empty()) {
    found.fault("section.corner_radius", with_unit(s.corner_radius, "m"),
                "has no effect: the corner is that of mesh.file", "absent with mesh.file",
                "leave it out");
    return;
  }
  if (!found.sound(plan_keys)) return;
  if (!too_large(found)) misses_the_mesh(found);
}

}  // namespace dccast::casting
