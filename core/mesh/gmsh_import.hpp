#pragma once

#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/errors.hpp"
#include "core/mesh/gmsh_reader.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::mesh {

/// A mesh under construction from a Gmsh file, with the faults found so far.
template <int Dim>
struct GmshImport {
  const gmsh::File& file;
  std::string name;  ///< of the file, for faults
  int shape;         ///< required shape of the elements, see gmsh_reader.hpp
  Faults& faults;
  Mesh<Dim> mesh{};
  std::unordered_map<long, int> number{};  ///< number of a node by its Gmsh tag

  void fault(const std::string& message,
             const std::string& permitted = "a mesh whose nodes, elements and groups fit together",
             const std::string& remedy = "correct the mesh and export it again") {
    faults.add("mesh.file", name, message, permitted, remedy);
  }

  /// Finds the node numbers of an element; false, with a fault, if it refers to a missing node.
  bool look_up(const gmsh::Element& element, std::vector<int>& nodes) {
    nodes.clear();
    for (int i = 0; i < gmsh::nodes_of(element.shape); ++i) {
      const long tag = element.node[static_cast<std::size_t>(i)];
      const auto found = number.find(tag);
      if (found == number.end()) {
        fault("has an element with the unknown node " + std::to_string(tag));
        return false;
      }
      nodes.push_back(found->second);
    }
    return true;
  }
};

/// Converts nodes and elements. All elements must have one shape, and none may be inverted.
template <int Dim>
void import_elements(GmshImport<Dim>& imported);

/// Creates patches from the physical groups of the boundary. @pre the elements have been converted
template <int Dim>
void import_patches(GmshImport<Dim>& imported);

extern template void import_elements(GmshImport<2>&);
extern template void import_elements(GmshImport<3>&);
extern template void import_patches(GmshImport<2>&);
extern template void import_patches(GmshImport<3>&);

}  // namespace dccast::mesh
