#pragma once

#include <optional>

#include "core/base/errors.hpp"
#include "core/mesh/base.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// Whether the file of a section holds the plan of a quarter slab, over which rows of cells grow,
/// or all cells of a slab that keeps its size. Without a file neither.
bool has_plan_file(const SectionSpec& spec);
bool has_mesh_file(const SectionSpec& spec);

/// Reads the plan of a quarter slab from the flat Gmsh mesh `file` of a section. Its cells are
/// divided by the section's refinement. Over a bowl the block sinks with the distance from the
/// nearest face.
/// @param spec    must have a plan file
/// @param faults  receives all faults, under the field "mesh.file"
/// @return        empty if there is a fault
std::optional<Base<3>> read_plan(const SectionSpec& spec, Faults& faults);

/// The cells of a plan as a flat mesh without patches.
Mesh<2> flat_mesh(const Base<3>& plan);

}  // namespace dccast::mesh
