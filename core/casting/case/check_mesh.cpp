#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/casting/case/checks.hpp"
#include "core/mesh/gmsh_reader.hpp"
#include "core/mesh/plan_file.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "core/results/temperature_file.hpp"

namespace dccast::casting {

namespace {

/// Keys that determine the number of rows, besides course_keys.
const Keys row_keys = {"section.kind",     "mesh.rows",           "section.initial_depth",
                       "mesh.bottom_cell", "mesh.growth_cell",    "mesh.refinement",
                       "mesh.element",     "limits.maximum_nodes"};
/// Keys that determine the number of cells in a row of the built-in mesh.
const Keys grid_keys = {"mesh.columns", "mesh.layers", "mesh.heat_cells_per_column",
                        "mesh.heat_cells_per_layer"};

/// Keys that determine the positions of its nodes, besides their number.
const Keys place_keys = {"section.half_width",   "section.half_thickness", "section.initial_depth",
                         "mesh.side_cell",       "mesh.wide_side_cell",    "mesh.bottom_cell",
                         "section.corner_radius"};

/// Tolerance of the size of a mesh relative to that of the case: drawings are rounded.
constexpr double size_tolerance = 0.01;

std::string name_of(const CaseFindings& found) {
  return found.casting.section.file.filename().string();
}

void too_many_nodes(CaseFindings& found, double nodes) {
  const mesh::SectionSpec& s = found.casting.section;
  const bool is_own = !s.file.empty();
  found.fault(
      is_own ? "mesh.file" : "mesh.columns", is_own ? name_of(found) : std::to_string(s.columns),
      "leads to " + with_unit(nodes, "nodes at the end"),
      "at most limits.maximum_nodes = " + std::to_string(found.casting.limits.maximum_nodes),
      "use fewer or larger cells, or raise the limit");
}

bool beyond_the_axis(CaseFindings& found, const mesh::Mesh2D& mesh) {
  double nearest = 0.0;
  for (int n = 0; n < mesh.nodes(); ++n) nearest = std::min(nearest, mesh.point(n)[0]);
  if (nearest >= 0.0) return false;
  found.fault("mesh.file", name_of(found),
              "has a node at " + with_unit(nearest, "m") + ", beyond the axis of the billet",
              "distances from the axis of 0 m and more with section.kind = \"axisymmetric\"",
              "mesh the right half of the section");
  return true;
}

/// Whether a length that was drawn is that of the case within the tolerance.
bool fits(double drawn, double metres) {
  return std::abs(drawn - metres) <= size_tolerance * metres;
}

/// Names the unit in which a length that should be `metres` was probably drawn.
/// @param key  that gives the length
std::string remedy_for_size(double drawn, double metres, const std::string& key) {
  for (const auto& [unit, factor, in_metres] : {std::tuple{"millimetres", "0.001", 1e-3},
                                                {"centimetres", "0.01", 1e-2},
                                                {"inches", "0.0254", 0.0254}})
    if (std::abs(drawn * in_metres - metres) <= 2.0 * size_tolerance * metres)
      return std::string("it is in ") + unit +
             ": export it in metres, in Gmsh with Mesh.ScalingFactor = " + factor;
  return "export the mesh in metres, or correct " + key;
}

/// Whether a mesh is as wide as the section, as far as that is known; else there is a fault.
/// @param width  of the mesh [m]
bool is_as_wide(CaseFindings& found, double width) {
  const double half_width = found.casting.section.half_width;
  if (!found.sound({"section.half_width"}) || fits(width, half_width)) return true;
  found.fault("mesh.file", name_of(found), "is " + with_unit(width, "m") + " wide",
              "section.half_width = " + with_unit(half_width, "m") + ", within 1 %",
              remedy_for_size(width, half_width, "section.half_width"));
  return false;
}

template <int Dim>
void check_size(CaseFindings& found, const mesh::Mesh<Dim>& mesh) {
  if (!is_as_wide(found, mesh.largest(0))) return;

  // The depth is the level of the metal, for which any value can be meant: only a warning.
  const double depth = mesh.largest(Dim - 1), expected = found.casting.section.initial_depth;
  if (found.sound({"section.initial_depth"}) && !fits(depth, expected)) {
    found.warning("mesh.file", name_of(found),
                  "is " + with_unit(depth, "m") + " high, and that is how deep the metal is",
                  "section.initial_depth = " + with_unit(expected, "m"), "make the two agree");
  }
}

/// Command by which Gmsh names a group of facets.
template <int Dim>
std::string named_in_gmsh(const std::string& name) {
  return std::string(" in Gmsh, Physical ") + (Dim == 2 ? "Curve" : "Surface") + "(\"" + name +
         "\") = {...}, ";
}

/// Checks that a patch has facets.
template <int Dim>
void need(CaseFindings& found, const mesh::Mesh<Dim>& mesh, mesh::PatchKind patch,
          const std::string& message, const std::string& names, const std::string& remedy) {
  if (!mesh::patch_nodes(mesh, patch).empty()) return;
  found.fault("mesh.file", name_of(found), message,
              std::string("a physical group of ") + (Dim == 2 ? "lines" : "surfaces") +
                  " with the name " + names,
              remedy);
}

template <int Dim>
void need_side(CaseFindings& found, const mesh::Mesh<Dim>& mesh) {
  constexpr bool section = Dim == 2;
  need(found, mesh, mesh::PatchKind::side,
       std::string("has no group '") + (section ? "side" : "side_...") +
           "': neither mould nor water would cool it",
       section ? "side" : "side_x, side_y or side_ and any name",
       (section ? "name the face" : "name the faces") +
           named_in_gmsh<Dim>(section ? "side" : "side_x") + "and export the mesh again");
}

/// A quarter slab needs two symmetry planes, one normal to each horizontal axis.
void need_both_planes(CaseFindings& found, const mesh::Mesh3D& mesh) {
  for (const auto& [name, axis] : {std::pair{"symmetry_x", 0}, std::pair{"symmetry_y", 1}}) {
    const bool held = std::ranges::any_of(mesh.patches, [axis = axis](const auto& patch) {
      return patch.kind == mesh::PatchKind::symmetry && !patch.facets.empty() &&
             patch.normal[std::size_t(axis)] < -0.99;
    });

    if (held) continue;
    found.fault("mesh.file", name_of(found),
                std::string("has no group '") + name + "': nothing would hold the slab along " +
                    (axis == 0 ? "x" : "y"),
                std::string("a physical group of surfaces with the name ") + name +
                    ", in the plane where that coordinate is zero",
                "name the plane" + named_in_gmsh<3>(name) + "or write mechanics.enabled = false");
  }
}

/// Checks that the patches that the case needs have a name: a boundary without one is free and
/// insulated.
template <int Dim>
void check_groups(CaseFindings& found, const mesh::Mesh<Dim>& mesh) {
  const Case& c = found.casting;
  const bool heat_is_solved = c.thermal.file.empty();

  // Without given temperatures, heat leaves through the side and metal enters through the top.
  if (heat_is_solved && found.sound({"thermal.file"})) {
    need_side(found, mesh);
    if (c.cooling.top != thermal::Top::insulated && found.sound({"cooling.top"}))
      need(found, mesh, mesh::PatchKind::top, "has no group 'top': nothing would be poured in",
           "top",
           "name the surface of the metal" + named_in_gmsh<Dim>("top") +
               "or write cooling.top = \"insulated\"");
  }

  if (c.mechanics.enabled && found.sound({"mechanics.enabled"})) {
    if constexpr (Dim == 2)
      need(found, mesh, mesh::PatchKind::symmetry,
           "has no group 'symmetry': nothing would hold the slab sideways", "symmetry",
           "name the symmetry plane or axis" + named_in_gmsh<2>("symmetry") +
               "or write mechanics.enabled = false");
    else
      need_both_planes(found, mesh);
  }
}

template <int Dim>
void check_mesh(CaseFindings& found) {
  const Case& c = found.casting;
  auto& mesh = std::get<std::optional<mesh::Mesh<Dim>>>(found.imported);
  mesh = mesh::read_gmsh<Dim>(c.section.file, c.section.element, found.faults);
  if (!mesh) return;

  found.estimate.nodes = mesh->nodes();
  found.estimate.elements = mesh->elements();
  if (found.sound({"limits.maximum_nodes"}) && mesh->nodes() > c.limits.maximum_nodes)
    too_many_nodes(found, mesh->nodes());

  // The size of a mesh in the wrong place is meaningless.
  bool misplaced = false;
  if constexpr (Dim == 2)
    misplaced =
        found.sound({"section.kind"}) && found.axisymmetric() && beyond_the_axis(found, *mesh);
  if (!misplaced) check_size(found, *mesh);

  check_groups(found, *mesh);
  estimate_effort(found);
}

/// Checks that a plan ends at the faces that the case gives: at the narrow face, and at the wide
/// face in the middle and at the break points of the opening.
void check_plan_size(CaseFindings& found, const mesh::Base<3>& plan) {
  const mesh::SectionSpec& s = found.casting.section;
  if (!is_as_wide(found, mesh::flat_mesh(plan).largest(0))) return;
  if (!found.sound({"section.half_width", "section.half_thickness"})) return;

  std::vector<double> places{0.0};
  for (const double point : s.half_thickness.at())
    if (point > 0.0 && !fits(point, s.half_width)) places.push_back(point);

  for (const double x : places) {
    const double drawn = mesh::reach_of(plan, x), opening = s.half_thickness(x);
    if (fits(drawn, opening)) continue;
    found.fault("mesh.file", name_of(found),
                "reaches to y = " + with_unit(drawn, "m") + " at x = " + with_unit(x, "m"),
                "section.half_thickness = " + with_unit(opening, "m") + " there, within 1 %",
                remedy_for_size(drawn, opening, "section.half_thickness"));
    return;
  }
}

/// Nodes and cells of a row of the mesh that has all results.
struct RowSize {
  std::int64_t nodes = 0, cells = 0;
};

RowSize built_in_row(const CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  const std::int64_t columns = std::int64_t(s.columns) * s.refinement * s.heat_cells.per_column;
  if (!found.solid()) return {columns + 1, columns};
  const std::int64_t layers = std::int64_t(s.layers) * s.refinement * s.heat_cells.per_layer;
  return {(columns + 1) * (layers + 1), columns * layers};
}

/// Of a plan as it is drawn, before its cells are divided. New nodes lie on sides and in cells.
RowSize divided_row(const mesh::Base<3>& plan, int refinement) {
  std::int64_t rim = 0;
  for (const auto& wall : plan.walls) rim += std::int64_t(wall.pieces.size());

  const std::int64_t cells = plan.cells(), sides = (4 * cells + rim) / 2, added = refinement - 1;
  return {plan.nodes() + sides * added + cells * added * added, cells * refinement * refinement};
}

/// Checks the number of nodes at the end, and estimates the effort.
void check_rows(CaseFindings& found, const RowSize& row) {
  const mesh::SectionSpec& s = found.casting.section;
  found.nodes_per_row = row.nodes;
  // Checked before any mesh is built: a growth cell of micrometres would exhaust the memory, and
  // one that follows from graded rows may be as small.
  const double most = 2.0 * static_cast<double>(found.casting.limits.maximum_nodes);
  const double at_start = double(s.rows) * s.refinement * static_cast<double>(row.nodes);
  if (at_start > most) return too_many_nodes(found, at_start);
  const double unmerged =
      mesh::unmerged_rows(s, *found.final_level) * static_cast<double>(row.nodes);
  if (!(unmerged <= most)) return too_many_nodes(found, unmerged);

  const std::int64_t rows = mesh::rows_at(s, *found.final_level);
  const std::int64_t in_a_cell = s.element != mesh::ElementKind::p1 ? 1 : found.solid() ? 6 : 2;

  found.estimate.nodes = (rows + 1) * row.nodes;
  found.estimate.elements = rows * row.cells * in_a_cell;
  if (found.estimate.nodes > found.casting.limits.maximum_nodes)
    too_many_nodes(found, static_cast<double>(found.estimate.nodes));
  estimate_effort(found);
}

/// Number of nodes at the start; empty if another fault prevents counting them.
std::optional<std::size_t> nodes_at_the_start(CaseFindings& found) {
  if (const auto& plane = std::get<0>(found.imported)) return std::size_t(plane->nodes());
  if (const auto& solid = std::get<1>(found.imported)) return std::size_t(solid->nodes());
  if (!found.sound({"mesh.file"}) || !found.sound(row_keys) || !found.sound(grid_keys) ||
      !found.sound(place_keys))
    return std::nullopt;
  const mesh::SectionSpec& s = found.casting.section;
  return std::size_t(found.solid() ? mesh::SlabMesh3D(s).heat_mesh().nodes()
                                   : mesh::SlabMesh2D(s).heat_mesh().nodes());
}

void temperature_range(CaseFindings& found, const results::TemperatureHistory& history) {
  const Case& c = found.casting;
  const double begin = -c.schedule.hold, end = c.time.end;
  if (history.begin() <= begin + 1e-9 && history.end() >= end - 1e-9) return;
  found.warning(
      "thermal.file", c.thermal.file.filename().string(),
      "does not cover the simulated time; its first and last temperatures are held outside",
      "from " + with_unit(begin, "s") + " to " + with_unit(end, "s"));
}

}  // namespace

void check_row_size(CaseFindings& found) {
  if (!found.casting.section.file.empty() ||
      !found.sound({"section.kind", "mesh.refinement", "limits.maximum_nodes"}) ||
      !found.sound(grid_keys))
    return;
  const std::int64_t nodes = built_in_row(found).nodes;
  if (nodes > found.casting.limits.maximum_nodes) too_many_nodes(found, static_cast<double>(nodes));
}

void check_built_in_size(CaseFindings& found) {
  if (!found.sound(row_keys) || !found.sound(grid_keys) || !found.sound(course_keys)) return;
  check_rows(found, built_in_row(found));
}

void check_plan_file(CaseFindings& found) {
  mesh::SectionSpec drawn = found.casting.section;
  if (!found.sound({"mesh.file", "mesh.element"})) return;
  if (drawn.element == mesh::ElementKind::p1)
    return found.fault("mesh.element", "p1", "needs tetrahedra, but a plan is built up of bricks",
                       "q1_bending or q1 with a plan in mesh.file",
                       "write element = \"q1_bending\"");

  drawn.refinement = 1;
  found.plan = mesh::read_plan(drawn, found.faults);
  if (!found.plan) return;

  check_plan_size(found, *found.plan);
  if (!found.sound(row_keys) || !found.sound(course_keys)) return;
  check_rows(found, divided_row(*found.plan, found.casting.section.refinement));
}

void check_imported_mesh(CaseFindings& found) {
  if (!found.sound({"mesh.file", "mesh.element", "section.kind", "mesh.growth"})) return;
  found.solid() ? check_mesh<3>(found) : check_mesh<2>(found);
}

void check_temperature_file(CaseFindings& found) {
  if (found.casting.thermal.file.empty() || !found.sound({"thermal.file"})) return;
  const auto nodes = nodes_at_the_start(found);
  if (!nodes) return;
  const auto history =
      results::read_temperature_file(found.casting.thermal.file, *nodes, found.faults);
  if (history && found.sound({"time.end", "schedule.hold"})) temperature_range(found, *history);
}

}  // namespace dccast::casting
