#include "core/mesh/plan_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "core/mesh/divided_mesh.hpp"
#include "core/mesh/gmsh_reader.hpp"

namespace dccast::mesh {

namespace {

constexpr double same_place = 1e-6;  // [m]

/// Puts the nodes of a middle plane exactly on it, so that they move along one axis only.
/// @param axis  coordinate that is zero there
/// @return      false, with a fault, if the plane is missing or lies elsewhere
bool settle_on_plane(Mesh<2>& mesh, int axis, const std::string& file, Faults& faults) {
  const char coordinate = axis == 0 ? 'x' : 'y';
  const std::string group = fmt::format("symmetry_{}", coordinate);
  const std::string permitted =
      fmt::format("a physical group of lines {} where {} is zero", group, coordinate);
  const Patch<2>* plane = mesh.find(group);
  if (plane == nullptr) {
    faults.add(
        "mesh.file", file, fmt::format("has no group '{}'", group), permitted,
        fmt::format("name the middle plane in Gmsh, Physical Curve(\"{}\") = {{...}}", group));
    return false;
  }

  for (const int n : patch_nodes(*plane)) {
    double& place = mesh.node[std::size_t(2 * n + axis)];
    if (std::abs(place) > same_place) {
      faults.add("mesh.file", file,
                 fmt::format("has a node of {} at {} = {:.6g} m", group, coordinate, place),
                 permitted, "draw a quarter of the slab, whose middle is at x = 0 and y = 0");
      return false;
    }
    place = 0.0;
  }
  return true;
}

/// Whether all nodes lie in the quarter; else there is a fault.
bool lies_in_quarter(const Mesh<2>& mesh, const std::string& file, Faults& faults) {
  const auto lowest = std::ranges::min_element(mesh.node);
  if (*lowest >= 0.0) return true;

  const int node = static_cast<int>(lowest - mesh.node.begin()) / 2;
  faults.add("mesh.file", file,
             fmt::format("has a node at ({:.6g}, {:.6g}) m, outside the quarter",
                         mesh.point(node)[0], mesh.point(node)[1]),
             "x and y of 0 m and more",
             "draw a quarter of the slab, whose middle is at x = 0 and y = 0");
  return false;
}

/// The plan of a flat mesh: its cells, and a wall for each straight part of a group.
Base<3> plan_of(const Mesh<2>& mesh) {
  Base<3> plan;
  plan.node = mesh.node;
  plan.cell_node = mesh.element_node;

  for (const Patch<2>& patch : mesh.patches) {
    const std::size_t first = plan.walls.size();
    if (patch.kind == PatchKind::symmetry) {
      const bool is_x = patch.name == "symmetry_x";
      plan.walls.push_back({patch.name, patch.kind, {is_x ? -1.0 : 0.0, is_x ? 0.0 : -1.0, 0}, {}});
    }

    for (const Facet<2>& facet : patch.facets) {
      const Base<3>::Piece piece{facet.element, first_corner(mesh, facet)};
      if (patch.kind == PatchKind::symmetry)
        plan.walls.back().pieces.push_back(piece);
      else
        add_piece(plan, first, patch.name, piece);
    }
  }
  return plan;
}

/// Distance of a point from a piece between two points [m].
double distance(const double* point, const double* a, const double* b) {
  const double along = b[0] - a[0], rise = b[1] - a[1];
  const double projected = along * (point[0] - a[0]) + rise * (point[1] - a[1]);
  const double share = std::clamp(projected / (along * along + rise * rise), 0.0, 1.0);
  return std::hypot(point[0] - a[0] - share * along, point[1] - a[1] - share * rise);
}

/// Distance of a point from the nearest face, which is the edge of the block [m].
double distance_from_faces(const Base<3>& plan, const double* point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& wall : plan.walls) {
    if (wall.kind != PatchKind::side) continue;
    for (const auto& piece : wall.pieces) {
      const auto [a, b] = ends_of(plan, piece);
      nearest = std::min(nearest, distance(point, a, b));
    }
  }
  return nearest;
}

}  // namespace

bool has_plan_file(const SectionSpec& spec) {
  return !spec.file.empty() && spec.growth && spec.kind == SectionKind::quarter_slab;
}

bool has_mesh_file(const SectionSpec& spec) {
  return !spec.file.empty() && !has_plan_file(spec);
}

std::optional<Base<3>> read_plan(const SectionSpec& spec, Faults& faults) {
  std::optional<Mesh<2>> mesh = read_gmsh_plan(spec.file, faults);
  if (!mesh) return std::nullopt;

  const std::string file = spec.file.filename().string();
  const bool on_x = settle_on_plane(*mesh, 0, file, faults);
  const bool on_y = settle_on_plane(*mesh, 1, file, faults);
  if (!on_x || !on_y || !lies_in_quarter(*mesh, file, faults)) return std::nullopt;

  Base<3> plan = plan_of(divided(*mesh, spec.refinement));
  if (spec.bowl)
    for (std::size_t n = 0; n < plan.node.size(); n += 2)
      plan.depth.push_back(spec.bowl->depth_at(distance_from_faces(plan, &plan.node[n])));
  return plan;
}

Mesh<2> flat_mesh(const Base<3>& plan) {
  Mesh<2> mesh;
  mesh.node = plan.node;
  mesh.nodes_per_element = 4;
  mesh.element_node = plan.cell_node;
  return mesh;
}

}  // namespace dccast::mesh
