#include <algorithm>
#include <cmath>

#include "core/casting/case/checks.hpp"
#include "core/mesh/base.hpp"
#include "core/mesh/plan_file.hpp"
#include "core/mesh/slab_mesh.hpp"

namespace dccast::casting {

void check_section(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;

  // Rows grow over the plan of a quarter slab. The plan of a section is a line, and all cells of
  // its mesh file are fixed, as are the nodes of given temperatures.
  const bool growth_known = found.sound({"mesh.growth"});
  if (mesh::has_mesh_file(s) && s.growth && growth_known && found.sound({"section.kind"})) {
    found.fault("mesh.growth", "true", "the mesh of a section cannot grow: it has no rows",
                "false with mesh.file, or a plan with section.kind = \"quarter_slab\"",
                "leave mesh.file out and set mesh.columns, mesh.side_cell and mesh.rows, or write "
                "growth = false");
  }
  if (!found.casting.thermal.file.empty() && s.growth && growth_known) {
    found.fault("thermal.file", found.casting.thermal.file.filename().string(),
                "has one temperature per node, but the nodes of a growing slab increase in number",
                "mesh.growth = false with thermal.file", "write growth = false in [mesh]");
  }

  // Cells that are larger than the section or the first metal cannot be laid out.
  const double cell = s.growth_cell.value_or(s.initial_depth / s.rows);
  if (s.growth && found.sound({"mesh.growth_cell", "mesh.rows", "section.initial_depth"}) &&
      cell > s.initial_depth) {
    found.fault("mesh.growth_cell", with_unit(cell, "m"), "is higher than the metal at the start",
                "at most section.initial_depth = " + with_unit(s.initial_depth, "m"),
                "choose smaller growth cells");
  }

  if (s.file.empty() && found.sound({"mesh.side_cell", "section.half_width"}) &&
      s.side_cell > s.half_width) {
    found.fault("mesh.side_cell", with_unit(s.side_cell, "m"), "is wider than the section",
                "at most section.half_width = " + with_unit(s.half_width, "m"),
                "choose a smaller cell");
  }

  if (!mesh::has_mesh_file(s) && found.sound({"mesh.bottom_cell", "section.initial_depth"}) &&
      s.bottom_cell > s.initial_depth) {
    found.fault("mesh.bottom_cell", with_unit(s.bottom_cell, "m"), "is higher than the metal",
                "at most section.initial_depth = " + with_unit(s.initial_depth, "m"),
                "choose a smaller cell");
  }

  if (found.sound({"section.kind", "mesh.element", "mechanics.enabled"}) && found.axisymmetric() &&
      found.casting.mechanics.enabled && s.element == mesh::ElementKind::p1) {
    // A creeping tube of triangles is 26 % off where one of quadrilaterals is 1.5 %
    // (`dccast-verify run tube-creep`). Nor does the liquid's pressure, one value a triangle,
    // carry its weight near the axis.
    found.fault("mesh.element", "p1", "triangles lock in an axisymmetric section",
                "q1_bending or q1 with mechanics and section.kind = \"axisymmetric\"",
                "write element = \"q1_bending\"");
  }
}

// Conditions on the plan of a quarter slab.

namespace {

/// Slope of piece `i` of a table [1].
double slope(const Curve& table, std::size_t i) {
  return (table.value()[i + 1] - table.value()[i]) / (table.at()[i + 1] - table.at()[i]);
}

/// Checks that the wide face of a mould is convex or flat: towards the narrow face its opening
/// never increases, and it never narrows less steeply than before.
void opening_not_convex(CaseFindings& found, const Curve& opening, double half_width) {
  const char* permitted = "values that never rise and fall ever more steeply: a convex mould";
  double steepest = 0.0;
  for (std::size_t i = 0; i + 1 < opening.at().size(); ++i) {
    const double falls = slope(opening, i);
    if (falls > steepest + length_round_off) {
      found.fault("section.half_thickness", with_unit(opening.at()[i + 1], "m"),
                  falls > 0.0 ? "widens towards the narrow face up to here"
                              : "narrows less than before up to here, so that the face is hollow",
                  permitted, "lower the values outside of this point, or raise those inside");
      return;
    }
    steepest = falls;
  }

  if (steepest < 0.0 && opening.at().back() < half_width - length_round_off) {
    found.fault("section.half_thickness", with_unit(opening.at().back(), "m"),
                "is the last point of the table, beyond which the face would run straight",
                "a last point at section.half_width = " + with_unit(half_width, "m"),
                "add the opening at the narrow face");
  }
}

/// Whether each break point of a quarter slab's opening has a row of nodes in its plan.
bool break_points_have_nodes(const mesh::SectionSpec& s) {
  const auto base = mesh::base_of<3>(s);
  std::vector<double> x;
  const int column = s.layers * s.refinement + 1;
  for (int n = 0; n < base.nodes(); n += column) x.push_back(base.node[2 * std::size_t(n)]);

  bool fits = std::ranges::is_sorted(x, std::less_equal{});
  for (const double point : s.half_thickness.at()) {
    const bool inside = point > 0.0 && point < s.half_width - length_round_off;
    fits &= !inside || std::ranges::any_of(x, [&](double other) {
      return std::abs(other - point) <= length_round_off;
    });
  }
  return fits;
}

/// Checks that each break point of the opening has a column of nodes. A rounded corner moves nodes,
/// so it is left out here and checked by check_corner().
void columns_miss_break_points(CaseFindings& found) {
  mesh::SectionSpec square = found.casting.section;
  square.corner_radius = 0.0;
  if (break_points_have_nodes(square)) return;
  found.fault("mesh.columns", std::to_string(square.columns),
              "are too few for the break points of section.half_thickness",
              "so many that each break point can have a row of nodes",
              "use more columns, or move the break points apart");
}

/// Checks the table of the opening, and that the mesh can follow it.
void check_opening(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  if (s.half_thickness.empty())
    return found.fault(
        "section.half_thickness", "", "is missing",
        "half the opening of the mould in metres, one value or a table against distance",
        "write half_thickness = \"0.285 m\" for a rectangular slab");

  if (!found.sound({"section.half_width"})) return;
  opening_not_convex(found, s.half_thickness, s.half_width);
  if (!s.file.empty() || !found.sound({"section.half_thickness"})) return;

  const double narrowest = s.half_thickness(s.half_width);
  if (found.sound({"mesh.wide_side_cell"}) && s.wide_side_cell > narrowest) {
    found.fault("mesh.wide_side_cell", with_unit(s.wide_side_cell, "m"),
                "is wider than half the slab", "at most " + with_unit(narrowest, "m"),
                "choose a smaller cell");
  }

  if (found.sound(plan_keys)) columns_miss_break_points(found);
}

/// Largest radius of a corner: it ends before the symmetry planes and before the last break point
/// of the opening.
double largest_radius(const mesh::SectionSpec& s) {
  double last = 0.0;
  for (const double point : s.half_thickness.at())
    if (point < s.half_width - length_round_off) last = std::max(last, point);
  return std::min(s.half_width - last, s.half_thickness(s.half_width));
}

/// Checks that the rounded corner of a quarter slab fits its plan and its mesh.
void check_corner(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  if (s.corner_radius <= 0.0) return;
  const auto fault = [&](const std::string& message, const std::string& permitted,
                         const char* remedy) {
    found.fault("section.corner_radius", with_unit(s.corner_radius, "m"), message, permitted,
                remedy);
  };

  if (!s.file.empty())
    return fault("has no effect: the corner is that of mesh.file", "absent with mesh.file",
                 "leave it out");

  if (!found.sound(plan_keys)) return;
  const double most = largest_radius(s);
  if (s.corner_radius > most + length_round_off)
    return fault(
        "reaches beyond the middle of the slab or the last break point of "
        "section.half_thickness",
        "at most " + with_unit(most, "m"), "choose a smaller radius");

  // An arc of two cells on each side is the coarsest that the mesh can round.
  const auto cells = mesh::corner_cells(s);
  if (std::min(cells[0], cells[1]) < mesh::fewest_corner_cells)
    return fault("holds too few cells for an arc: " + std::to_string(cells[0]) +
                     " along the wide face, " + std::to_string(cells[1]) + " along the narrow face",
                 "2 cells or more along each, about " +
                     with_unit(2.0 * std::max(s.side_cell, s.wide_side_cell), "m") +
                     " with these cells, or 0 m for a square corner",
                 "choose a larger radius, or smaller mesh.side_cell and mesh.wide_side_cell");

  if (!break_points_have_nodes(s))
    fault("ends in the row of nodes of a break point of section.half_thickness",
          "an end with a row of nodes of its own",
          "use more mesh.columns, or move the break point away from the corner");
}

/// Checks that rows can be merged: cells are not split into elements, and two growth cells fit into
/// a merged one.
void check_merging(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  if (s.merging.below <= 0.0 || mesh::has_mesh_file(s) ||
      !found.sound({"mesh.merge_below", "mesh.element"}))
    return;

  if (s.element == mesh::ElementKind::p1) {
    found.fault("mesh.merge_below", with_unit(s.merging.below, "m"),
                "is given, but tetrahedra cannot be merged", "q1_bending or q1 with it",
                "leave it out, or choose mesh.element = \"q1_bending\"");
    return;
  }

  // A merged cell replaces two growth cells.
  if (!found.sound({"mesh.growth_cell", "mesh.merged_cell", "mesh.rows", "mesh.bottom_cell",
                    "section.initial_depth"}))
    return;
  const double pair = 2.0 * mesh::growth_cell(s) * s.refinement;
  if (s.merging.largest_cell >= pair * (1.0 - 1e-9)) return;
  found.fault("mesh.merged_cell", with_unit(s.merging.largest_cell, "m"),
              "is less than two growth cells, so that nothing would be merged",
              "at least " + with_unit(pair, "m"), "raise it, or write merge_below = \"0 m\"");
}

/// The keys of a heat mesh of its own that are not 1.
std::vector<const char*> given_heat_cells(const mesh::SectionSpec& s) {
  std::vector<const char*> keys;
  if (s.heat_cells.per_column != 1) keys.push_back("mesh.heat_cells_per_column");
  if (s.heat_cells.per_layer != 1) keys.push_back("mesh.heat_cells_per_layer");
  return keys;
}

/// Checks that the cells of the heat can divide those of the mechanics.
void check_heat_cells(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  for (const char* key : given_heat_cells(s)) {
    if (!s.file.empty())
      found.fault(key, "given", "has no effect: heat and mechanics both use mesh.file",
                  "1, or absent, with mesh.file", "leave it out");
    else if (s.element == mesh::ElementKind::p1 && found.sound({"mesh.element"}))
      found.fault(key, "given", "divides bricks, and tetrahedra are not divided",
                  "q1_bending or q1 with it",
                  "leave it out, or choose mesh.element = \"q1_bending\"");
  }
}

}  // namespace

void quarter_slab_only(CaseFindings& found, const char* key, bool given) {
  if (!given || !found.sound({"section.kind"})) return;
  found.fault(key, "given", "applies to a quarter slab only",
              "section.kind = \"quarter_slab\" with it",
              "leave it out, or write kind = \"quarter_slab\"");
}

void check_quarter_slab(CaseFindings& found) {
  const Case& c = found.casting;
  if (found.solid()) {
    if (found.sound({"section.half_thickness"})) check_opening(found);
    check_corner(found);
    check_merging(found);
    check_heat_cells(found);
    return;
  }

  quarter_slab_only(found, "section.half_thickness", !c.section.half_thickness.empty());
  quarter_slab_only(found, "section.corner_radius", c.section.corner_radius > 0.0);
  quarter_slab_only(found, "mesh.merge_below", c.section.merging.below > 0.0);
  for (const char* key : given_heat_cells(c.section)) quarter_slab_only(found, key, true);
  quarter_slab_only(found, "cooling.bottom_block.profile_y",
                    !c.cooling.bottom_block.profile_y.empty());
}

}  // namespace dccast::casting
