#include <algorithm>
#include <set>

#include "core/mesh/gmsh_import.hpp"

namespace dccast::mesh {

namespace {

constexpr const char* shape_name[] = {"",           "lines",    "triangles", "quadrilaterals",
                                      "tetrahedra", "hexahedra"};

template <int Dim>
class Elements {
public:
  explicit Elements(GmshImport<Dim>& imported) : import_(imported) {}

  void take() {
    const std::size_t before = import_.faults.list().size();
    number_nodes();
    check_shapes();
    if (import_.faults.list().size() == before) add_elements();
  }

private:
  void number_nodes() {
    for (std::size_t i = 0; i < import_.file.node_tag.size(); ++i)
      if (!import_.number.emplace(import_.file.node_tag[i], static_cast<int>(i)).second)
        return import_.fault("has node " + std::to_string(import_.file.node_tag[i]) + " twice");
    for (const auto& position : import_.file.node) {
      if (Dim == 2 && position[2] != 0.0)
        return import_.fault("has nodes with z other than 0", "a section in the x-y plane, in m");
      import_.mesh.node.insert(import_.mesh.node.end(), position.begin(), position.begin() + Dim);
    }
  }

  void check_shapes() {
    std::set<int> found;
    for (const gmsh::Element& element : import_.file.elements)
      if (gmsh::dimension_of(element.shape) >= Dim) found.insert(element.shape);
    if (found.size() == 1 && *found.begin() == import_.shape) return;
    std::string names;
    for (const int shape : found)
      names += (names.empty() ? "" : " and ") + std::string(shape_name[shape]);
    import_.fault(
        "has " + (names.empty() ? "no elements" : names),
        std::string("only ") + shape_name[import_.shape] + " with this mesh.element",
        Dim == 2
            ? "mesh.element = \"p1\" for triangles, \"q1_bending\" or \"q1\" for quadrilaterals"
            : "");
  }

  void add_elements() {
    import_.mesh.nodes_per_element = gmsh::nodes_of(import_.shape);
    std::vector<char> used(import_.file.node.size(), 0);
    std::vector<int> nodes;
    for (const gmsh::Element& element : import_.file.elements) {
      if (element.shape != import_.shape) continue;
      if (!import_.look_up(element, nodes) || !orient(nodes)) return;
      for (const int n : nodes) used[static_cast<std::size_t>(n)] = 1;
      import_.mesh.element_node.insert(import_.mesh.element_node.end(), nodes.begin(), nodes.end());
    }
    if (const auto orphans = std::count(used.begin(), used.end(), 0); orphans > 0)
      import_.fault(
          "has " + std::to_string(orphans) + " nodes that belong to no element", "none",
          "save only the nodes of physical groups (Mesh.SaveAll = 0), without construction points");
  }

  /// Twice the signed area, or six times the signed volume, at the corner of an element.
  double corner_measure(int corner, int a, int b, int c) const {
    double edge[3][Dim];
    const int ends[3] = {a, b, c};
    for (int i = 0; i < Dim; ++i)
      for (int d = 0; d < Dim; ++d)
        edge[i][d] = import_.mesh.point(ends[i])[d] - import_.mesh.point(corner)[d];
    if constexpr (Dim == 2) {
      return edge[0][0] * edge[1][1] - edge[0][1] * edge[1][0];
    } else {
      return edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1]) -
             edge[0][1] * (edge[1][0] * edge[2][2] - edge[1][2] * edge[2][0]) +
             edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0]);
    }
  }

  /// Smallest and largest measure over the corners: both have the same sign in a valid element.
  std::pair<double, double> measures(const std::vector<int>& n) const {
    std::vector<double> values;
    if (import_.shape == gmsh::triangle) {
      values = {corner_measure(n[0], n[1], n[2], 0)};
    } else if (import_.shape == gmsh::tetrahedron) {
      values = {corner_measure(n[0], n[1], n[2], n[3])};
    } else {
      const std::size_t layers = Dim == 2 ? 1 : 2;
      for (std::size_t layer = 0; layer < layers; ++layer) {
        for (std::size_t i = 0; i < 4; ++i) {
          const int next = n[4 * layer + (i + 1) % 4];
          const int previous = n[4 * layer + (i + 3) % 4];
          const int across = Dim == 2 ? 0 : n[4 * (1 - layer) + i];
          const double measure = corner_measure(n[4 * layer + i], next, previous, across);
          values.push_back(layer == 0 ? measure : -measure);
        }
      }
    }
    const auto [smallest, largest] = std::minmax_element(values.begin(), values.end());
    return {*smallest, *largest};
  }

  /// Reverses a negative element; returns false, with a fault, if it is folded or degenerate.
  bool orient(std::vector<int>& nodes) {
    const auto [smallest, largest] = measures(nodes);
    if (smallest > 0.0) return true;
    if (largest < 0.0) {
      turn_round(nodes);
      return true;
    }
    import_.fault("has a folded or flat element at (" +
                      std::to_string(import_.mesh.point(nodes[0])[0]) + ", " +
                      std::to_string(import_.mesh.point(nodes[0])[1]) + ") m",
                  "elements with all corners below 180 degrees");
    return false;
  }

  void turn_round(std::vector<int>& nodes) const {
    if (import_.shape == gmsh::triangle || import_.shape == gmsh::tetrahedron)
      return std::swap(nodes[1], nodes[2]);
    for (std::size_t layer = 0; layer < nodes.size() / 4; ++layer)
      std::swap(nodes[4 * layer + 1], nodes[4 * layer + 3]);
  }

  GmshImport<Dim>& import_;
};

}  // namespace

template <int Dim>
void import_elements(GmshImport<Dim>& imported) {
  Elements<Dim>(imported).take();
}

template void import_elements(GmshImport<2>&);
template void import_elements(GmshImport<3>&);

}  // namespace dccast::mesh
