#include "core/case/check/checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "core/mesh/gmsh_reader.hpp"

namespace dccast::casting {

namespace {

/// Tolerance of the width of a mesh relative to the half width of the case: drawings are rounded.
constexpr double width_tolerance = 0.01;
constexpr double depth_tolerance = 0.01;

template <int Dim>
double largest(const mesh::Mesh<Dim>& mesh, std::size_t coordinate) {
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

/// The unit in which a length that should be `metres` was probably drawn.
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

template <int Dim>
void check_size(CaseFindings& found, const mesh::Mesh<Dim>& mesh) {
  const double width = largest(mesh, 0), depth = largest(mesh, Dim - 1);
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

/// By dimension, from 2.
constexpr NeededGroup side_group[] = {
    {mesh::PatchKind::side, "side", "has no group 'side': neither mould nor water would cool it",
     "name the face in Gmsh, Physical Curve(\"side\") = {...}, and export the mesh again"},
    {mesh::PatchKind::side, "side_x, side_y or side_ and any name",
     "has no group 'side_...': neither mould nor water would cool it",
     "name the faces in Gmsh, Physical Surface(\"side_x\") = {...}, and export the mesh again"}};
constexpr NeededGroup top_group[] = {
    {mesh::PatchKind::top, "top", "has no group 'top': nothing would be poured in",
     "name the surface of the metal in Gmsh, Physical Curve(\"top\") = {...}, or write "
     "cooling.top = \"insulated\""},
    {mesh::PatchKind::top, "top", "has no group 'top': nothing would be poured in",
     "name the surface of the metal in Gmsh, Physical Surface(\"top\") = {...}, or write "
     "cooling.top = \"insulated\""}};
constexpr NeededGroup symmetry_group{
    mesh::PatchKind::symmetry, "symmetry",
    "has no group 'symmetry': nothing would hold the slab sideways",
    "name the symmetry plane or axis in Gmsh, Physical Curve(\"symmetry\") = {...}, or "
    "write mechanics.enabled = false"};

template <int Dim>
void need(CaseFindings& found, const mesh::Mesh<Dim>& mesh, const NeededGroup& group) {
  if (!mesh::patch_nodes(mesh, group.patch).empty()) return;
  found.fault("mesh.file", name_of(found), group.message,
              std::string("a physical group of ") + (Dim == 2 ? "lines" : "surfaces") +
                  " with the name " + group.name,
              group.remedy);
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
                std::string("name the plane in Gmsh, Physical Surface(\"") + name +
                    "\") = {...}, or write mechanics.enabled = false");
  }
}

/// Boundary without a name is free and insulated. Patches that the case needs must have a name.
template <int Dim>
void check_groups(CaseFindings& found, const mesh::Mesh<Dim>& mesh) {
  const Case& c = found.casting;
  const bool heat_is_solved = c.thermal.file.empty();
  if (heat_is_solved && found.sound({"thermal.file"})) {
    need(found, mesh, side_group[Dim - 2]);
    if (c.cooling.top != thermal::Top::insulated && found.sound({"cooling.top"}))
      need(found, mesh, top_group[Dim - 2]);
  }
  if (c.mechanics.enabled && found.sound({"mechanics.enabled"})) {
    if constexpr (Dim == 2)
      need(found, mesh, symmetry_group);
    else
      need_both_planes(found, mesh);
  }
}

template <int Dim>
void check_mesh(CaseFindings& found) {
  const Case& c = found.casting;
  auto& mesh = found.imported<Dim>();
  mesh = mesh::read_gmsh<Dim>(c.section.file, c.section.element, found.faults);
  if (!mesh) return;
  found.estimate.nodes = mesh->nodes();
  found.estimate.elements = mesh->elements();
  if (found.sound({"limits.maximum_nodes"}) && mesh->nodes() > c.limits.maximum_nodes)
    too_many_nodes(found, mesh->nodes());
  bool misplaced = false;
  if constexpr (Dim == 2)
    misplaced =
        found.sound({"section.kind"}) && found.axisymmetric() && beyond_the_axis(found, *mesh);
  if (!misplaced) check_size(found, *mesh);
  check_groups(found, *mesh);
  estimate_effort(found);
}

}  // namespace

void check_imported_mesh(CaseFindings& found) {
  if (!found.sound({"mesh.file", "mesh.element", "section.kind"})) return;
  found.solid() ? check_mesh<3>(found) : check_mesh<2>(found);
}

}  // namespace dccast::casting
