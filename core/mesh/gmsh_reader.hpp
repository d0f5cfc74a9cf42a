#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/errors.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// Reads a Gmsh mesh, MSH 2.2 or 4.1 in ASCII, length unit the metre.
///
/// Boundary facets belong to physical groups named symmetry, bottom, side and top, in 3D also
/// symmetry_x, symmetry_y and any name that begins with side_. The group bottom is required. Each
/// outer facet is in a group; those of the group free are insulated and move freely. Cells share
/// whole facets. Elements of negative orientation are reversed.
/// Nodes keep the order of the file, which is the order of the columns of a temperature file.
/// Facets of a patch are ordered along it: from the symmetry plane, or upwards.
///
/// @param path    the file
/// @param kind    p1 needs triangles (tetrahedra in 3D), the others quadrilaterals (hexahedra)
/// @param faults  receives all faults, under the field "mesh.file"
/// @return        empty if there is a fault
template <int Dim>
std::optional<Mesh<Dim>> read_gmsh(const std::filesystem::path& path, ElementKind kind,
                                   Faults& faults);

/// Reads the content of a Gmsh file. @param name  file name for the messages
template <int Dim>
std::optional<Mesh<Dim>> parse_gmsh(std::string_view text, const std::string& name,
                                    ElementKind kind, Faults& faults);

/// Reads the plan of a quarter slab: a flat mesh of quadrilaterals, and the lines of its outline in
/// groups named symmetry_x, symmetry_y and any name that begins with side_. Each side of the
/// outline must be in a group.
/// @param path    the file
/// @param faults  receives all faults, under the field "mesh.file"
/// @return        in x and y; empty if there is a fault
std::optional<Mesh<2>> read_gmsh_plan(const std::filesystem::path& path, Faults& faults);

/// Reads the content of such a file. @param name  file name for the messages
std::optional<Mesh<2>> parse_gmsh_plan(std::string_view text, const std::string& name,
                                       Faults& faults);

}  // namespace dccast::mesh
