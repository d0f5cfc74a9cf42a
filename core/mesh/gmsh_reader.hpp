#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/errors.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// Reads a Gmsh mesh, MSH 2.2 or 4.1 in ASCII, length unit the metre.
///
/// Boundary facets belong to physical groups named symmetry, bottom, side and top, in 3D also
/// symmetry_x, /// symmetry_y and any name that begins with side_. The group bottom is required;
/// boundary without a group is free and insulated. Elements of negative orientation are reversed.
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

/// The same from the content of a file. @param name  file name for the messages
template <int Dim>
std::optional<Mesh<Dim>> parse_gmsh(std::string_view text, const std::string& name,
                                    ElementKind kind, Faults& faults);

extern template std::optional<Mesh<2>> read_gmsh(const std::filesystem::path&, ElementKind,
                                                 Faults&);
extern template std::optional<Mesh<3>> read_gmsh(const std::filesystem::path&, ElementKind,
                                                 Faults&);
extern template std::optional<Mesh<2>> parse_gmsh(std::string_view, const std::string&, ElementKind,
                                                  Faults&);
extern template std::optional<Mesh<3>> parse_gmsh(std::string_view, const std::string&, ElementKind,
                                                  Faults&);

}  // namespace dccast::mesh

/// Parsed content of a Gmsh file, not yet converted to a mesh. Formats: the Gmsh reference manual,
/// "MSH file format version 4.1" and "version 2 (Legacy)".
namespace dccast::mesh::gmsh {

/// The text is not a Gmsh file that can be read; what() says why.
class FormatError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Gmsh's numbers for the shapes of elements.
enum Shape : int {
  line = 1,
  triangle = 2,
  quadrilateral = 3,
  tetrahedron = 4,
  hexahedron = 5,
  point = 15
};

/// Number of nodes of a linear element; 0 for an unsupported shape.
int nodes_of(int shape);
/// Dimension of a linear element; -1 for an unsupported shape.
int dimension_of(int shape);

struct Element {
  int shape = 0;
  std::vector<int> groups;     ///< tags of its physical groups
  std::array<long, 8> node{};  ///< tags
};

struct File {
  std::map<std::pair<int, int>, std::string> group_name;  ///< by dimension and tag
  std::vector<long> node_tag;
  std::vector<std::array<double, 3>> node;  ///< [m]
  std::vector<Element> elements;            ///< of all dimensions
};

/// @param text  content of a file in MSH 2.2 or 4.1, ASCII
/// @throws FormatError
File parse(std::string_view text);

}  // namespace dccast::mesh::gmsh
