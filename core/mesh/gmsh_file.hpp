#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Parsed content of a Gmsh file, not yet converted to a mesh. Formats: the Gmsh reference manual,
/// "MSH file format version 4.1" and "version 2 (Legacy)".
namespace dccast::mesh::gmsh {

/// The text is not a Gmsh file that can be read; what() is the reason.
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
constexpr int nodes_of(int shape) {
  constexpr std::array nodes{0, 2, 3, 4, 4, 8};
  if (shape == point) return 1;
  return shape < line || shape > hexahedron ? 0 : nodes[std::size_t(shape)];
}
/// Dimension of a linear element; -1 for an unsupported shape.
constexpr int dimension_of(int shape) {
  constexpr std::array dimensions{-1, 1, 2, 2, 3, 3};
  if (shape == point) return 0;
  return shape < line || shape > hexahedron ? -1 : dimensions[std::size_t(shape)];
}

/// An element of a file.
struct Element {
  /// Number of the shape, as Gmsh counts its kinds of elements.
  int shape = 0;
  std::vector<int> groups;     ///< tags of its physical groups
  std::array<long, 8> node{};  ///< tags
};

/// Content of a file.
struct File {
  std::map<std::pair<int, int>, std::string> group_name;  ///< by dimension and tag
  std::vector<long> node_tag;                             ///< (node)
  std::vector<std::array<double, 3>> node;                ///< (node) [m]
  std::vector<Element> elements;                          ///< of all dimensions
};

/// Parses the content of a file in MSH 2.2 or 4.1, ASCII. @throws FormatError
File parse(std::string_view text);

}  // namespace dccast::mesh::gmsh
