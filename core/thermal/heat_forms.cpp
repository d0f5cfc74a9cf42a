#include "core/thermal/heat_forms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/fem/element.hpp"
#include "core/fem/facet_pieces.hpp"
#include "core/thermal/element_conduction.hpp"
#include "core/thermal/growth.hpp"

namespace dccast::thermal {

/// The forms of a mesh with one kind of element.
template <class Element>
class HeatFormsOf : public HeatForms {
  static constexpr int dim = Element::dimension;
  using Mesh = mesh::Mesh<dim>;
  using Facet = mesh::Facet<dim>;

public:
  explicit HeatFormsOf(const Mesh& mesh) : mesh_(mesh) {}

  /// Integrates only the part of the mesh that has grown, stretched or merged; the result is
  /// bit-identical to an integration of the whole mesh.
  bool update() override {
    const bool changed = element_node_ != mesh_.element_node || volume_.empty();
    const std::size_t from = first_node_to_integrate();
    if (changed) take_elements(from > 0 && element_node_.size() <= mesh_.element_node.size());
    integrate_from(from);
    placed_ = mesh_.node;
    return changed;
  }

  int nodes() const override { return mesh_.nodes(); }
  linalg::Geometry geometry() const override {
    return dim == 2 ? linalg::Geometry::plane : linalg::Geometry::solid;
  }
  std::array<std::vector<int>, 2> fronts() const override {
    return mesh::edges_to_sweep_from(mesh_, 1);
  }
  std::optional<mesh::Extrusion> extrusion() const override {
    if constexpr (dim == 3)
      return mesh::extrusion_of(mesh_);
    else
      return std::nullopt;
  }

  double divide_side(const CoolingSpec& cooling, const SideInstant& instant,
                     std::vector<SideShare>& shares) const override {
    shares.clear();
    const SideLaws laws(cooling, instant);

    double lowest = INFINITY, highest = -INFINITY;
    mesh::for_each_facet(mesh_, mesh::PatchKind::side, [&](const Facet& facet, const auto& patch) {
      const Face face = face_of(patch);
      for (int i = 0; i < facet.nodes; ++i) {
        const double height = mesh_.point(facet.node[std::size_t(i)])[dim - 1];
        lowest = std::min(lowest, height);
        highest = std::max(highest, height);
      }

      // Cut the facet at the edges of the cooling laws, so that each piece has one law.
      const auto use = [&](const auto& piece) {
        add_piece(facet, piece, face, laws.at(piece.middle_level, face), shares);
      };
      cut(facet, depth_of(facet, instant)).for_each_piece(laws.edges(), use);
    });

    return highest - lowest;
  }

  MetalEntry follow_growth(int nodes_per_row, double entering_enthalpy,
                           std::vector<double>& enthalpy, bool& new_pattern) override {
    const std::vector<double> before = volume_;
    const std::size_t row = std::size_t(nodes_per_row), old_elements = element_node_.size();
    new_pattern = update();

    // Enthalpy is first carried to the old rows, stretched to the new level, then to the new rows.
    const bool divided = before.size() < volume_.size();
    const std::vector<double> stretched =
        divided ? stretched_volumes(before, row, old_elements) : volume_;

    std::vector<double> height;
    for (std::size_t n = before.size() - 2 * row; n < volume_.size(); n += row)
      height.push_back(mesh_.point(static_cast<int>(n))[dim - 1]);

    return carry_enthalpy({row, before, stretched, volume_, height}, entering_enthalpy, enthalpy);
  }

private:
  /// @param grown  elements were added to the existing ones
  void take_elements(bool grown) {
    element_node_ = mesh_.element_node;
    if (grown) {
      pattern_.extend(mesh_.nodes(), element_node_);
    } else {
      pattern_ = linalg::SparsityPattern(mesh_.nodes(), element_node_, mesh_.nodes_per_element);
    }
    stiffness_.resize(pattern_.entries());
    volume_.resize(std::size_t(mesh_.nodes()));
    bottom_nodes_ = mesh::patch_nodes(mesh_, mesh::PatchKind::bottom);
    top_nodes_ = mesh::patch_nodes(mesh_, mesh::PatchKind::top);
    find_side_columns();
    find_bottom_places();
    find_bottom_paths();
  }

  void find_bottom_places() {
    bottom_places_.clear();
    for (const int n : bottom_nodes_)
      bottom_places_.push_back({mesh_.point(n)[0], dim == 3 ? mesh_.point(n)[1] : 0.0});
  }

  void find_bottom_paths() {
    std::map<int, std::size_t> number;
    for (std::size_t i = 0; i < bottom_nodes_.size(); ++i) number[bottom_nodes_[i]] = i;

    std::map<std::pair<std::size_t, std::size_t>, double> length;
    mesh::for_each_facet(mesh_, mesh::PatchKind::bottom, [&](const Facet& facet, const auto&) {
      for (std::size_t a = 0; a < std::size_t(facet.nodes); ++a) {
        for (std::size_t b = 0; b < a; ++b) {
          const double *p = mesh_.point(facet.node[a]), *q = mesh_.point(facet.node[b]);
          double squared = 0.0;
          for (std::size_t d = 0; d < dim; ++d) squared += (p[d] - q[d]) * (p[d] - q[d]);
          length[std::minmax(number.at(facet.node[a]), number.at(facet.node[b]))] =
              std::sqrt(squared);
        }
      }
    });

    bottom_paths_.clear();
    for (const auto& [nodes, metres] : length)
      bottom_paths_.push_back({nodes.first, nodes.second, metres});
  }

  /// Numbers the columns of side nodes: nodes at the same place of the plan form one.
  void find_side_columns() {
    constexpr double same_place = 1e-9;  // [m]
    const std::vector<int> nodes = mesh::patch_nodes(mesh_, mesh::PatchKind::side);
    std::map<std::array<long long, dim - 1>, int> columns;
    side_column_.assign(std::size_t(mesh_.nodes()), -1);

    for (const int n : nodes) {
      std::array<long long, dim - 1> place{};
      for (std::size_t d = 0; d + 1 < dim; ++d)
        place[d] = std::llround(mesh_.point(n)[d] / same_place);
      side_column_[std::size_t(n)] =
          columns.try_emplace(place, static_cast<int>(columns.size())).first->second;
    }

    // A mesh without columns, such as an imported one, is treated as a single column.
    if (2 * columns.size() <= nodes.size()) return;
    for (const int n : nodes) side_column_[std::size_t(n)] = 0;
  }

  /// First node of an element that is new, lost its neighbour or has a node that has moved.
  std::size_t first_node_to_integrate() const {
    const std::vector<int>&known = element_node_, &present = mesh_.element_node;
    const std::size_t common = std::min(known.size(), present.size());
    if (common == 0 ||
        !std::equal(present.begin(), present.begin() + std::ptrdiff_t(common), known.begin()))
      return 0;

    const auto end = placed_.begin() + std::ptrdiff_t(std::min(placed_.size(), mesh_.node.size()));
    const auto changed = std::mismatch(placed_.begin(), end, mesh_.node.begin()).first;
    std::size_t moved = std::size_t(changed - placed_.begin()) / dim;
    for (const auto* elements : {&known, &present}) {
      for (std::size_t i = common; i < elements->size(); ++i)
        moved = std::min(moved, std::size_t((*elements)[i]));
    }
    return first_node_beside(moved, present.size());
  }

  /// First node of the elements that have a node numbered `moved` or higher.
  /// @param end  end of their part in the list of element nodes
  std::size_t first_node_beside(std::size_t moved, std::size_t end) const {
    std::size_t first = moved;
    for_each_element_from(moved, end, [&](const int* node) {
      first = std::min(first, std::size_t(*std::min_element(node, node + Element::nodes)));
    });
    return first;
  }

  /// Calls use(nodes) for every element that has a node numbered `first` or higher.
  template <class Use>
  void for_each_element_from(std::size_t first, std::size_t end, const Use& use) const {
    for (std::size_t position = 0; position < end; position += Element::nodes) {
      const int* node = mesh_.element_node.data() + position;
      if (std::size_t(*std::max_element(node, node + Element::nodes)) >= first) use(node);
    }
  }

  void integrate_from(std::size_t first) {
    const auto entry = std::size_t(pattern_.diagonal(static_cast<int>(first)));
    std::fill(stiffness_.begin() + std::ptrdiff_t(entry), stiffness_.end(), 0.0);
    std::fill(volume_.begin() + std::ptrdiff_t(first), volume_.end(), 0.0);
    for_each_element_from(first, mesh_.element_node.size(), [&](const int* node) {
      integrate(static_cast<int>((node - mesh_.element_node.data()) / Element::nodes), first);
    });
    const auto last = std::max_element(bottom_nodes_.begin(), bottom_nodes_.end());
    if (last != bottom_nodes_.end() && std::size_t(*last) >= first)
      weigh(mesh::PatchKind::bottom, bottom_nodes_, bottom_weight_);
    weigh(mesh::PatchKind::top, top_nodes_, top_weight_);
  }

  /// Adds the contribution of an element to the nodes numbered `first` or higher.
  void integrate(int e, std::size_t first) {
    constexpr std::size_t corners = Element::nodes;
    const int* node = mesh_.nodes_of(e);
    const int* place = pattern_.places(e);
    const auto conduction = conduction_of<Element>(mesh_, node);

    // Nodes below `first` keep what they had.
    const auto counts = [&](std::size_t i) { return std::size_t(node[i]) >= first; };
    for (std::size_t i = 0; i < corners; ++i) {
      if (counts(i)) volume_[std::size_t(node[i])] += conduction.volume[i];
    }

    // Stiffness by nodal quadrature: the volume of each corner times the product of the gradients
    // there. The matrix is symmetric, so only its lower triangle is filled.
    for (std::size_t c = 0; c < corners; ++c) {
      const auto& gradient = conduction.gradient[c];
      for (std::size_t i = 0; i < corners; ++i) {
        for (std::size_t k = 0; k <= i; ++k) {
          if (!counts(i) || !counts(k)) continue;
          double product = gradient[i][0] * gradient[k][0];
          for (std::size_t a = 1; a < dim; ++a) product += gradient[i][a] * gradient[k][a];
          stiffness_[std::size_t(place[i * corners + k])] += conduction.volume[c] * product;
        }
      }
    }
  }

  /// Integrals of the shape functions over a patch, by its nodes.
  void weigh(mesh::PatchKind kind, const std::vector<int>& nodes, std::vector<double>& weight) {
    std::vector<SideShare> shares;
    mesh::for_each_facet(mesh_, kind, [&](const Facet& facet, const auto&) {
      cut(facet, {}).for_each_piece(
          {}, [&](const auto& piece) { add_piece(facet, piece, Face::wide, {}, shares); });
    });

    std::vector<double> by_node(volume_.size(), 0.0);
    for (const SideShare& share : shares) by_node[std::size_t(share.node)] += share.weight;

    weight.clear();
    for (const int node : nodes) weight.push_back(by_node[std::size_t(node)]);
  }

  /// Levels by which a facet is cut: the distance of its nodes below the metal level [m].
  using Levels = std::array<double, dim == 2 ? 2 : 4>;
  Levels depth_of(const Facet& facet, const SideInstant& instant) const {
    Levels depth{};
    for (std::size_t i = 0; i < std::size_t(facet.nodes); ++i) {
      depth[i] = instant.mould_level - mesh_.point(facet.node[i])[dim - 1];
      if (!instant.rise.empty()) depth[i] -= instant.rise[std::size_t(facet.node[i])];
    }
    return depth;
  }

  auto cut(const Facet& facet, const Levels& level) const {
    if constexpr (dim == 3) {
      return fem::FaceCut(mesh_, facet, level);
    } else {
      const double *a = mesh_.point(facet.node[0]), *b = mesh_.point(facet.node[1]);
      constexpr bool round = fem::is_axisymmetric<Element>;
      return fem::EdgeCut(std::hypot(b[0] - a[0], b[1] - a[1]), level,
                          {round ? a[0] : 1.0, round ? b[0] : 1.0});
    }
  }

  /// The only side of a 2D section counts as wide.
  static Face face_of(const mesh::Patch<dim>& patch) {
    if constexpr (dim == 2) return Face::wide;
    return std::abs(patch.normal[0]) > std::abs(patch.normal[1]) ? Face::narrow : Face::wide;
  }

  /// One share per Gauss point if the law depends on the distance, which makes the integral exact.
  static void add_piece(const Facet& facet, const fem::EdgePiece& piece, Face face,
                        const LawAt& law, std::vector<SideShare>& shares) {
    for (std::size_t n = 0; n < 2; ++n) {
      double sum = 0.0;
      for (std::size_t g = 0; g < 2; ++g) {
        const double weight = piece.weight[n][g];
        if (law.by_distance)
          shares.push_back({facet.node[n], law.number, weight, piece.level[g], face});
        sum += weight;
      }
      if (!law.by_distance)
        shares.push_back({facet.node[n], law.number, sum, piece.middle_level, face});
    }
  }

  /// A law linear in the distance is integrated exactly by its value at the mean distance weighted
  /// by the shape function.
  static void add_piece(const Facet& facet, const fem::FacePiece& piece, Face face,
                        const LawAt& law, std::vector<SideShare>& shares) {
    for (std::size_t n = 0; n < std::size_t(facet.nodes); ++n) {
      if (piece.weight[n] > 0.0)
        shares.push_back({facet.node[n], law.number, piece.weight[n], piece.level[n], face});
    }
  }

  /// Nodal volumes of the mesh before growth, with its top row stretched to the present level
  /// [m^Dim], [m3/rad]. @param volume  (node) before growth [m^Dim], [m3/rad]
  std::vector<double> stretched_volumes(std::vector<double> volume, std::size_t row,
                                        std::size_t old_elements) const {
    const std::size_t nodes = volume.size(), first = first_node_beside(nodes - row, old_elements);

    Mesh stretched;
    stretched.node.assign(mesh_.node.begin(), mesh_.node.begin() + std::ptrdiff_t(dim * nodes));
    for (std::size_t n = nodes - row; n < nodes; ++n)
      stretched.node[dim * n + dim - 1] = mesh_.node.back();

    // Only elements of the top row have changed their volume.
    std::fill(volume.begin() + std::ptrdiff_t(first), volume.end(), 0.0);
    for_each_element_from(first, old_elements, [&](const int* node) {
      const auto corner = corner_volumes<Element>(stretched, node);
      for (std::size_t i = 0; i < corner.size(); ++i) {
        if (std::size_t(node[i]) >= first) volume[std::size_t(node[i])] += corner[i];
      }
    });
    return volume;
  }

  const Mesh& mesh_;
  std::vector<int> element_node_;
  std::vector<double> placed_;  ///< coordinates at the last integration [m]
};

void HeatForms::follow_merging(const mesh::MergedRows& merged, std::vector<double>& enthalpy) {
  const std::vector<double> before = volume_;
  update();
  merge_enthalpy(merged, before, volume_, enthalpy);
}

// For conduction the bending elements are plain bilinear and trilinear ones.

std::unique_ptr<HeatForms> make_heat_forms(const mesh::Mesh<2>& mesh, mesh::SectionKind kind) {
  using Forms = std::unique_ptr<HeatForms>;
  return fem::with_linear_element<2>(mesh.nodes_per_element, [&]<class Element>() -> Forms {
    if (kind == mesh::SectionKind::axisymmetric)
      return std::make_unique<HeatFormsOf<fem::Axisymmetric<Element>>>(mesh);
    return std::make_unique<HeatFormsOf<Element>>(mesh);
  });
}

std::unique_ptr<HeatForms> make_heat_forms(const mesh::Mesh<3>& mesh, mesh::SectionKind) {
  using Forms = std::unique_ptr<HeatForms>;
  return fem::with_linear_element<3>(mesh.nodes_per_element, [&]<class Element>() -> Forms {
    return std::make_unique<HeatFormsOf<Element>>(mesh);
  });
}

}  // namespace dccast::thermal
