#include "core/casting/check/checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "core/mesh/gmsh_reader.hpp"

namespace dccast::casting {

namespace {

/// Of the width of a mesh against the half width of the case: drawings are rounded.
constexpr double width_tolerance = 0.01;
constexpr double depth_tolerance = 0.01;

double largest(const mesh::Mesh2D& mesh, std::size_t coordinate) {
  double value = 0.0;
  for (int n = 0; n < mesh.nodes(); ++n) value = std::max(value, mesh.point(n)[coordinate]);
  return value;
}

std::string name_of(const CaseFindings& found) {
  return found.casting.section.file.filename().string();
}

bool beyond_the_axis(CaseFindings& found, const mesh::Mesh2D& mesh) {
  double nearest = 0.0;
  for (int n = 0; n < mesh.nodes(); ++n) nearest = std::min(nearest, mesh.point(n)[0]);
  if (nearest >= 0.0) return false;
  found.fault("mesh.file", found.casting.section.file.filename().string(),
              "has a node at " + with_unit(nearest, "m") + ", beyond the axis of the billet",
              "distances from the axis of 0 m and more with section.kind = \"axisymmetric\"",
              "mesh the right half of the section");
  return true;
}

/// What unit a length was probably drawn in that should have been `metres`.
std::string remedy_for_size(double drawn, double metres) {
  struct Unit {
    const char* name;
    double in_metres;
  };
  for (const Unit unit :
       {Unit{"millimetres", 1e-3}, Unit{"centimetres", 1e-2}, Unit{"inches", 0.0254}}) {
    if (std::abs(drawn * unit.in_metres - metres) > 2.0 * width_tolerance * metres) continue;
    char factor[32];
    std::snprintf(factor, sizeof factor, "%g", unit.in_metres);
    return std::string("it is in ") + unit.name +
           ": export it in metres, in Gmsh with Mesh.ScalingFactor = " + factor;
  }
  return "export the mesh in metres, or correct section.half_width";
}

void check_size(CaseFindings& found) {
  const double width = largest(*found.imported, 0), depth = largest(*found.imported, 1);
  const double half_width = found.casting.section.half_width;
  if (found.sound({"section.half_width"}) &&
      std::abs(width - half_width) > width_tolerance * half_width) {
    found.fault("mesh.file", name_of(found), "is " + with_unit(width, "m") + " wide",
                "section.half_width = " + with_unit(half_width, "m") + ", within 1 %",
                remedy_for_size(width, half_width));
    return;
  }
  const double expected = found.casting.section.initial_depth;
  if (found.sound({"section.initial_depth"}) &&
      std::abs(depth - expected) > depth_tolerance * expected) {
    found.warning("mesh.file", name_of(found),
                  "is " + with_unit(depth, "m") + " high, and that is how deep the metal is",
                  "section.initial_depth = " + with_unit(expected, "m"), "make the two agree");
  }
}

struct NeededGroup {
  mesh::PatchKind patch;
  const char* name;
  const char* message;
  const char* remedy;
};

void need(CaseFindings& found, const NeededGroup& group) {
  if (!found.imported->facets(group.patch).empty()) return;
  found.fault("mesh.file", name_of(found), group.message,
              std::string("a physical group of lines with the name ") + group.name, group.remedy);
}

/// Boundary without a name is free and insulated. What a case cannot do without must have one.
void check_groups(CaseFindings& found) {
  const Case& c = found.casting;
  const bool heat_is_solved = c.thermal.file.empty();
  if (heat_is_solved && found.sound({"thermal.file"})) {
    need(found,
         {mesh::PatchKind::side, "side", "has no group 'side': neither mould nor water would cool it",
          "name the face in Gmsh, Physical Curve(\"side\") = {...}, and export the mesh again"});
    if (c.cooling.top == thermal::Top::pouring && found.sound({"cooling.top"})) {
      need(found,
           {mesh::PatchKind::top, "top", "has no group 'top': nothing would be poured in",
            "name the surface of the metal in Gmsh, Physical Curve(\"top\") = {...}, or write "
            "cooling.top = \"insulated\""});
    }
  }
  if (c.mechanics.enabled && found.sound({"mechanics.enabled"})) {
    need(found,
         {mesh::PatchKind::symmetry, "symmetry",
          "has no group 'symmetry': nothing would hold the slab sideways",
          "name the symmetry plane or axis in Gmsh, Physical Curve(\"symmetry\") = {...}, or "
          "write mechanics.enabled = false"});
  }
}

}  // namespace

void check_imported_mesh(CaseFindings& found) {
  if (!found.sound({"mesh.file", "mesh.element"})) return;
  const Case& c = found.casting;
  found.imported = mesh::read_gmsh<2>(c.section.file, c.section.element, found.faults);
  if (!found.imported) return;
  found.estimate.nodes = found.imported->nodes();
  found.estimate.elements = found.imported->elements();
  const bool misplaced = found.sound({"section.kind"}) && found.axisymmetric() &&
                         beyond_the_axis(found, *found.imported);
  if (found.sound({"limits.maximum_nodes"}) && found.imported->nodes() > c.limits.maximum_nodes) {
    too_many_nodes(found, found.imported->nodes());
  }
  if (!misplaced) check_size(found);
  check_groups(found);
  estimate_effort(found);
}

}  // namespace dccast::casting
