#include "core/mesh/gmsh_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/mesh/cell_shape.hpp"
#include "core/mesh/gmsh_file.hpp"
#include "core/mesh/unglued.hpp"

namespace dccast::mesh {

namespace {

/// Mean of the outward normals of facets, weighted by area [1].
std::array<double, 3> mean_normal(const Mesh<3>& mesh, const std::vector<Facet<3>>& facets) {
  std::array<double, 3> sum{};
  for (const Facet<3>& facet : facets) {
    // Half the cross product of the diagonals; for a triangle, of two edges.
    const double* a = mesh.point(facet.node[0]);
    const double* b = mesh.point(facet.node[1]);
    const double* c = mesh.point(facet.node[2]);
    const double* d = facet.nodes == 4 ? mesh.point(facet.node[3]) : a;

    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      sum[i] += 0.5 * ((c[j] - a[j]) * (d[k] - b[k]) - (c[k] - a[k]) * (d[j] - b[j]));
    }
  }

  const double length = std::hypot(sum[0], sum[1], sum[2]);
  for (double& component : sum) component /= length > 0.0 ? length : 1.0;
  return sum;
}

/// Group of a boundary that is insulated and moves freely.
constexpr const char* free_name = "free";

/// What a file is read as.
enum class Content { section, plan, solid };

/// A mesh under construction from a Gmsh file.
template <int Dim>
class GmshImport {
public:
  /// @param name  of the file, for faults
  GmshImport(const gmsh::File& file, const std::string& name, Content content, ElementKind kind,
             Faults& faults)
      : file_(file),
        name_(name),
        content_(content),
        shape_(cell_shape(Dim, kind)),
        faults_(faults),
        faults_before_(faults.list().size()) {}

  /// The mesh; empty if there is a fault.
  std::optional<Mesh<Dim>> convert() {
    check_dimension();
    if (!is_valid()) return std::nullopt;
    number_nodes();
    check_shapes();
    if (is_valid()) add_elements();
    if (is_valid()) find_boundary();
    if (is_valid()) check_glued();
    if (is_valid()) add_patches();
    if (is_valid()) check_patches();
    if (!is_valid()) return std::nullopt;

    if (content_ != Content::plan) sort_patches();
    find_normals();
    return std::move(mesh_);
  }

private:
  using Key = std::array<int, 4>;  ///< sorted nodes of a facet, -1 where it has fewer than four

  static constexpr int no_patch = -1;
  static constexpr int free_patch = -2;  ///< of a boundary that is left free on purpose

  struct Boundary {
    Facet<Dim> facet;
    int elements = 0;  ///< that share it
    int patch = no_patch;
  };

  bool is_valid() const { return faults_.list().size() == faults_before_; }

  void add_fault(
      const std::string& message,
      const std::string& permitted = "a mesh whose nodes, elements and groups fit together",
      const std::string& remedy = "correct the mesh and export it again") {
    faults_.add("mesh.file", name_, message, permitted, remedy);
  }

  /// Finds the node numbers of an element; false, with a fault, if it refers to a missing node.
  bool look_up(const gmsh::Element& element, std::vector<int>& nodes) {
    nodes.clear();
    for (int i = 0; i < gmsh::nodes_of(element.shape); ++i) {
      const long tag = element.node[static_cast<std::size_t>(i)];
      const auto found = number_.find(tag);
      if (found == number_.end()) {
        add_fault(fmt::format("has an element with the unknown node {}", tag));
        return false;
      }
      nodes.push_back(found->second);
    }
    return true;
  }

  /// A flat mesh and a solid one are different castings, between which mesh.growth decides.
  void check_dimension() {
    int highest = 0;
    for (const gmsh::Element& element : file_.elements)
      highest = std::max(highest, gmsh::dimension_of(element.shape));

    if (content_ == Content::plan && highest == 3)
      add_fault("is a solid mesh, which has no rows that could grow",
                "a flat mesh of the plan with mesh.growth = true",
                "mesh the plan alone (docs/own-mesh.md), or write mesh.growth = false");
    if (content_ == Content::solid && highest == 2)
      add_fault("is a flat mesh without a solid element", "a solid mesh with mesh.growth = false",
                "write mesh.growth = true to cast on this plan, or mesh the volume");
  }

  /// By how much heights of a flat mesh may differ: a rotation in Gmsh leaves 1e-17 m.
  double flatness() const {
    constexpr double of_size = 1e-6;
    double size = 0.0;
    for (const auto& position : file_.node)
      size = std::max({size, std::abs(position[0]), std::abs(position[1])});
    return of_size * size;
  }

  void number_nodes() {
    for (std::size_t i = 0; i < file_.node_tag.size(); ++i)
      if (!number_.emplace(file_.node_tag[i], static_cast<int>(i)).second)
        return add_fault(fmt::format("has node {} twice", file_.node_tag[i]));

    const double flat = flatness();
    for (const auto& position : file_.node) {
      if (content_ == Content::section && std::abs(position[2]) > flat)
        return add_fault("has nodes with z other than 0", "a section in the x-y plane, in m");
      if (content_ == Content::plan && std::abs(position[2] - file_.node.front()[2]) > flat)
        return add_fault("has nodes at several heights", "a plan with one z, in m");
      mesh_.node.insert(mesh_.node.end(), position.begin(), position.begin() + Dim);
    }
  }

  void check_shapes() {
    std::set<int> found;
    for (const gmsh::Element& element : file_.elements)
      if (gmsh::dimension_of(element.shape) >= Dim) found.insert(element.shape);
    if (found.size() == 1 && *found.begin() == shape_.gmsh) return;

    if (found.empty())
      return add_fault("has no cells", fmt::format("{} in a physical group", shape_.plural),
                       fmt::format("add Physical {}(\"metal\") = {{...}} in Gmsh, which saves the "
                                   "cells of physical groups alone",
                                   Dim == 2 ? "Surface" : "Volume"));

    // Other elements than the wanted ones: say what was found.
    std::vector<const char*> names;
    for (const int shape : found) names.push_back(find_gmsh_shape(shape)->plural);
    const std::string message = fmt::format("has {}", fmt::join(names, " and "));
    if (content_ == Content::plan)
      return add_fault(message, fmt::format("only {} in a plan", shape_.plural),
                       "in Gmsh, Recombine Surface {...}");
    add_fault(
        message, fmt::format("only {} with this mesh.element", shape_.plural),
        Dim == 2
            ? "mesh.element = \"p1\" for triangles, \"q1_bending\" or \"q1\" for quadrilaterals"
            : "");
  }

  void add_elements() {
    mesh_.nodes_per_element = shape_.nodes;
    std::vector<char> used(file_.node.size(), 0);
    std::vector<int> nodes;

    std::map<std::array<long, 8>, std::set<int>> groups_of_cell;
    for (const gmsh::Element& element : file_.elements) {
      if (element.shape != shape_.gmsh) continue;
      // MSH 2.2 repeats a cell for each of its groups. Twice in one group it is two cells.
      auto& groups = groups_of_cell[element.node];
      const int group = element.groups.empty() ? 0 : element.groups.front();
      const bool is_known = !groups.empty();
      if (groups.insert(group).second && is_known) continue;

      if (!look_up(element, nodes) || !orient(nodes)) return;
      for (const int n : nodes) used[static_cast<std::size_t>(n)] = 1;
      mesh_.element_node.insert(mesh_.element_node.end(), nodes.begin(), nodes.end());
    }

    // A node without an element has no equation.
    if (const auto orphans = std::count(used.begin(), used.end(), 0); orphans > 0)
      add_fault(
          fmt::format("has {} nodes that belong to no element", orphans), "none",
          "save only the nodes of physical groups (Mesh.SaveAll = 0), without construction points");
  }

  /// Whether the elements are triangles or tetrahedra.
  bool is_simplex() const { return shape_.nodes == Dim + 1; }

  /// Twice the signed area, or six times the signed volume, at the corner of an element.
  double corner_measure(int corner, int a, int b, int c) const {
    double edge[3][Dim];
    const int ends[3] = {a, b, c};
    for (int i = 0; i < Dim; ++i)
      for (int d = 0; d < Dim; ++d) edge[i][d] = mesh_.point(ends[i])[d] - mesh_.point(corner)[d];

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
    if (is_simplex()) {
      values = {corner_measure(n[0], n[1], n[2], Dim == 2 ? 0 : n[3])};
    } else {
      const std::size_t layers = Dim == 2 ? 1 : 2;
      for (std::size_t layer = 0; layer < layers; ++layer) {
        for (std::size_t i = 0; i < 4; ++i) {
          const int next = n[4 * layer + (i + 1) % 4];
          const int previous = n[4 * layer + (i + 3) % 4];
          const int across = Dim == 2 ? 0 : n[4 * (1 - layer) + i];

          // In the upper layer the corners turn the other way.
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
      reverse(nodes);
      return true;
    }
    const double* corner = mesh_.point(nodes[0]);
    add_fault(fmt::format("has a folded or flat element at ({:f}, {:f}) m", corner[0], corner[1]),
              "elements with all corners below 180 degrees");
    return false;
  }

  void reverse(std::vector<int>& nodes) const {
    if (is_simplex()) return std::swap(nodes[1], nodes[2]);
    for (std::size_t layer = 0; layer < nodes.size() / 4; ++layer)
      std::swap(nodes[4 * layer + 1], nodes[4 * layer + 3]);
  }

  /// The key of a facet. @param count  number of its nodes
  template <class Nodes>
  static Key make_key(const Nodes& nodes, std::size_t count) {
    Key key;
    key.fill(-1);
    std::copy_n(nodes.begin(), count, key.begin());
    std::sort(key.begin(), key.end());
    return key;
  }

  /// Counts the elements at every facet: the boundary has one.
  void find_boundary() {
    for (int e = 0; e < mesh_.elements(); ++e) {
      for (const auto& corners : shape_.facets) {
        Facet<Dim> facet;
        facet.nodes = static_cast<int>(corners.size());
        facet.element = e;
        // The first element that has a facet owns it.
        for (std::size_t i = 0; i < corners.size(); ++i)
          facet.node[i] = mesh_.nodes_of(e)[corners[i]];

        Boundary& boundary = boundary_[make_key(facet.node, corners.size())];
        if (boundary.elements == 0) boundary.facet = facet;
        if (++boundary.elements == 2) neighbours_.emplace_back(boundary.facet.element, e);
        if (boundary.elements > 2)
          return add_fault("has elements that overlap: three share a facet");
      }
    }
  }

  /// A place in the mesh, for messages: "(0.1, 0.2) m".
  std::string place(int node) const {
    return fmt::format("({:.6g}) m", fmt::join(mesh_.point(node), mesh_.point(node) + Dim, ", "));
  }

  /// Neither heat nor force passes between cells that do not share their nodes.
  void check_glued() {
    constexpr const char* permitted = "neighbouring cells that share whole sides and their nodes";
    std::vector<Facet<Dim>> outer;
    for (const auto& [key, boundary] : boundary_)
      if (boundary.elements == 1) outer.push_back(boundary.facet);

    if (const auto found = find_unglued<Dim>(mesh_, outer)) {
      const bool hangs = found->same_place < 0;
      const long tag = file_.node_tag[std::size_t(found->node)];
      return add_fault(
          fmt::format("has cells that touch but are not joined, at {} nodes, at first at {}: {}",
                      found->nodes, place(found->node),
                      hangs ? fmt::format("node {} hangs in the side of a cell", tag)
                            : fmt::format("nodes {} and {} lie at one place",
                                          file_.node_tag[std::size_t(found->same_place)], tag)),
          permitted,
          hangs ? "divide the cells on both sides alike, in Gmsh with the same Transfinite Curve "
                  "and without a second curve at that place (Coherence)"
                : "in Gmsh, Coherence (BooleanFragments with OpenCASCADE) before the mesh is made, "
                  "or Coherence Mesh after it");
    }

    const Pieces pieces = find_pieces(mesh_.elements(), neighbours_);
    if (pieces.number > 1)
      add_fault(fmt::format("lies in {} pieces that share no side of a cell; one of them is at {}",
                            pieces.number, place(mesh_.nodes_of(pieces.second)[0])),
                permitted, "mesh one body; cells that meet at a corner or an edge are not joined");
  }

  /// The kind of a patch by its name. A section has one of each; a solid may have several planes of
  /// symmetry and several sides, as symmetry_x, side_2.
  std::optional<PatchKind> find_kind(const std::string& name) const {
    if (content_ == Content::plan) return find_kind_of_outline(name);

    for (std::size_t k = 0; k < patch_kinds; ++k) {
      const PatchKind kind = PatchKind(k);
      const std::string plain = name_of(kind);
      const bool several = kind == PatchKind::symmetry || kind == PatchKind::side;
      if (name == plain || (Dim == 3 && several && name.starts_with(plain + "_"))) return kind;
    }
    return std::nullopt;
  }

  /// The outline of a plan has the two middle planes and sides.
  static std::optional<PatchKind> find_kind_of_outline(const std::string& name) {
    if (name == "symmetry_x" || name == "symmetry_y") return PatchKind::symmetry;
    if (name.starts_with("side_")) return PatchKind::side;
    return std::nullopt;
  }

  /// The names that find_kind() knows.
  const char* known_names() const {
    switch (content_) {
      case Content::section:
        return "symmetry, bottom, side, top, or free";
      case Content::plan:
        return "symmetry_x, symmetry_y, side_x, side_y, or side_ and any name";
      case Content::solid:
        return "symmetry_x, symmetry_y, bottom, side_x, side_y, top, side_ and any name, or free";
    }
    return "";
  }

  /// The index of the patch of a physical group, or `free_patch`; `no_patch`, with one fault, if
  /// its name is unknown.
  int find_patch(int group) {
    const auto found = file_.group_name.find({Dim - 1, group});
    const std::string name =
        found == file_.group_name.end() ? std::to_string(group) : found->second;

    if (name == free_name && content_ != Content::plan) return free_patch;

    auto& patches = mesh_.patches;
    const auto known = std::ranges::find(patches, name, &Patch<Dim>::name);
    if (known != patches.end()) return static_cast<int>(known - patches.begin());
    // A name that is new and known becomes a patch.
    if (const auto kind = find_kind(name)) {
      patches.push_back({name, *kind, usual_normal<Dim>(*kind), {}});
      return static_cast<int>(patches.size()) - 1;
    }

    // A group may be met once for each of its facets.
    if (unknown_.insert(name).second)
      add_fault(fmt::format("has the unknown physical group '{}'", name.substr(0, 60)),
                known_names());
    return no_patch;
  }

  std::string patch_name(int patch) const {
    return patch == free_patch ? free_name : mesh_.patches[std::size_t(patch)].name;
  }

  /// Adds a facet of the boundary to a patch.
  void add_facet(const std::vector<int>& nodes, int patch) {
    const auto found = boundary_.find(make_key(nodes, nodes.size()));
    if (found == boundary_.end() || found->second.elements != 1)
      return add_fault(fmt::format(
          "has a facet of group {} that is not on the boundary of the mesh", patch_name(patch)));

    Boundary& boundary = found->second;
    if (boundary.patch == patch) return;  // Gmsh repeats a facet for each of its groups
    if (boundary.patch != no_patch)
      return add_fault(fmt::format("has a facet in two groups, {} and {}",
                                   patch_name(boundary.patch), patch_name(patch)));

    boundary.patch = patch;
    if (patch != free_patch) mesh_.patches[std::size_t(patch)].facets.push_back(boundary.facet);
  }

  void add_patches() {
    std::vector<int> nodes;
    for (const gmsh::Element& element : file_.elements) {
      if (gmsh::dimension_of(element.shape) != Dim - 1) continue;
      for (const int group : element.groups) {
        const int patch = find_patch(group);
        if (patch == no_patch) continue;
        if (!look_up(element, nodes)) return;

        const std::size_t faults_before = faults_.list().size();
        add_facet(nodes, patch);
        if (faults_.list().size() != faults_before) return;  // the following would be the same
      }
    }
  }

  /// Each outer side of a cell is cooled, held, or left free on purpose; a plan has no free sides.
  void check_patches() {
    if (content_ != Content::plan && mesh_.facets(PatchKind::bottom).empty())
      return add_fault("has no physical group 'bottom'",
                       "the part of the boundary that stands on the block");
    need_groups_all_around();
  }

  void need_groups_all_around() {
    int sides = 0;
    const Facet<Dim>* first = nullptr;
    for (const auto& [key, boundary] : boundary_) {
      if (boundary.elements != 1 || boundary.patch != no_patch) continue;
      if (sides++ == 0) first = &boundary.facet;
    }

    if (sides == 0) return;
    std::vector<std::string> corners;
    for (int i = 0; i < first->nodes; ++i) corners.push_back(place(first->node[std::size_t(i)]));
    add_fault(
        fmt::format("has {} outer {} of cells without a group, at first that between {}", sides,
                    sides == 1 ? "side" : "sides", fmt::join(corners, ", ")),
        fmt::format("each outer side in a physical group {}", known_names()),
        fmt::format("name it in Gmsh with Physical {}{}", Dim == 2 ? "Curve" : "Surface",
                    content_ == Content::plan ? "" : ", as free if nothing is to cool or hold it"));
  }

  /// Orders the facets of each patch: bottom and top from the symmetry plane, the others upwards.
  void sort_patches() {
    for (Patch<Dim>& patch : mesh_.patches) {
      const bool level = patch.kind == PatchKind::bottom || patch.kind == PatchKind::top;
      const int axis = level ? 0 : Dim - 1;
      const auto place = [&](const Facet<Dim>& facet) {
        double sum = 0.0;
        for (int i = 0; i < facet.nodes; ++i) sum += mesh_.point(facet.node[std::size_t(i)])[axis];
        return sum / facet.nodes;
      };

      std::stable_sort(patch.facets.begin(), patch.facets.end(),
                       [&](const auto& a, const auto& b) { return place(a) < place(b); });
    }
  }

  /// In 3D the normal of a patch is that of its facets.
  void find_normals() {
    if constexpr (Dim == 3) {
      for (Patch<3>& patch : mesh_.patches) patch.normal = mean_normal(mesh_, patch.facets);
    }
  }

  const gmsh::File& file_;
  const std::string& name_;
  Content content_;
  const CellShape& shape_;  ///< required of the elements
  Faults& faults_;
  std::size_t faults_before_;
  Mesh<Dim> mesh_;
  std::unordered_map<long, int> number_;  ///< of a node by its Gmsh tag
  std::map<Key, Boundary> boundary_;
  std::vector<std::pair<int, int>> neighbours_;  ///< elements that share a facet
  std::set<std::string> unknown_;                ///< names of groups that have a fault
};

template <int Dim>
std::optional<Mesh<Dim>> parse(std::string_view text, const std::string& name, Content content,
                               ElementKind kind, Faults& faults) {
  try {
    const gmsh::File file = gmsh::parse(text);
    return GmshImport<Dim>(file, name, content, kind, faults).convert();
  } catch (const gmsh::FormatError& error) {
    faults.add("mesh.file", name, error.what(), "MSH 2.2 or 4.1, ASCII",
               "export it from Gmsh as MSH 4.1 or 2.2 in ASCII");
    return std::nullopt;
  }
}

/// The text of a file; empty, with a fault, if it cannot be read.
std::optional<std::string> read_text(const std::filesystem::path& path, Faults& faults) {
  std::ifstream stream;

  // A folder can be opened, but not read.
  if (!std::filesystem::is_directory(path)) stream.open(path, std::ios::binary);
  if (!stream.is_open()) {
    faults.add("mesh.file", path.filename().string(), "cannot be read", "a readable Gmsh mesh",
               "name an existing file, or leave mesh.file out");
    return std::nullopt;
  }
  return std::string{std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

template <int Dim>
std::optional<Mesh<Dim>> parse_gmsh(std::string_view text, const std::string& name,
                                    ElementKind kind, Faults& faults) {
  return parse<Dim>(text, name, Dim == 2 ? Content::section : Content::solid, kind, faults);
}

template <int Dim>
std::optional<Mesh<Dim>> read_gmsh(const std::filesystem::path& path, ElementKind kind,
                                   Faults& faults) {
  const auto text = read_text(path, faults);
  if (!text) return std::nullopt;
  return parse_gmsh<Dim>(*text, path.filename().string(), kind, faults);
}

std::optional<Mesh<2>> parse_gmsh_plan(std::string_view text, const std::string& name,
                                       Faults& faults) {
  return parse<2>(text, name, Content::plan, ElementKind::q1, faults);
}

std::optional<Mesh<2>> read_gmsh_plan(const std::filesystem::path& path, Faults& faults) {
  const auto text = read_text(path, faults);
  if (!text) return std::nullopt;
  return parse_gmsh_plan(*text, path.filename().string(), faults);
}

template std::optional<Mesh<2>> read_gmsh(const std::filesystem::path&, ElementKind, Faults&);
template std::optional<Mesh<3>> read_gmsh(const std::filesystem::path&, ElementKind, Faults&);
template std::optional<Mesh<2>> parse_gmsh(std::string_view, const std::string&, ElementKind,
                                           Faults&);
template std::optional<Mesh<3>> parse_gmsh(std::string_view, const std::string&, ElementKind,
                                           Faults&);

}  // namespace dccast::mesh
