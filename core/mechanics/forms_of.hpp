#pragma once

#include <algorithm>
#include <stdexcept>

#include "core/mechanics/element_forms.hpp"
#include "core/mechanics/local_frames.hpp"
#include "core/mechanics/mechanics_forms.hpp"
#include "core/mechanics/solid_bending_forms.hpp"

namespace dccast::mechanics {

/// The forms of a mesh with one kind of element: gathers nodal values for ElementForms and scatters
/// their results. ElementForms work on as many elements at once as a register has lanes.
///
/// Units: as in MechanicsForms.
template <class Element>
class FormsOf final : public MechanicsForms<Element::dimension> {
  static constexpr int dimension = Element::dimension;
  using Base = MechanicsForms<dimension>;
  using Forms = ElementForms<Element>;
  template <int Count>
  using FormsOfSeveral = ElementForms<Element, Lanes<Count>>;
  using Vectors = typename Forms::Vectors;
  using Matrix = typename Forms::Matrix;
  using Rotations = ElementRotations<dimension>;
  static constexpr std::size_t nodes = Forms::nodes, dim = Forms::dim, of_element = Forms::points,
                               unknowns = Forms::unknowns;

public:
  using typename Base::Mesh, typename Base::Tensor;

  /// @copydoc MechanicsForms::update. A mesh with another number of elements loses its frames.
  void update(const Mesh& mesh, std::size_t first = 0) override {
    mesh_ = &mesh;
    if (mesh.elements() != geometry_.elements()) frames_ = {};
    rotations_.clear();
    taking_part_.clear();
    geometry_.update(mesh, static_cast<int>(first));
  }
  void set_frames(std::span<const NodalFrame<dimension>> frames) override {
    frames_.set(*mesh_, frames);
  }
  /// The mean gradient of an element at `u` determines its rotation; see rotation_of().
  /// @param u      by unknown [m]
  /// @param solid  (element) not zero: the axes follow the rotation
  void set_rotations(std::span<const double> u, std::span<const char> solid) override {
    rotations_.clear();
    if constexpr (fem::is_axisymmetric<Element>) {
      throw std::logic_error("an axisymmetric element has no rotation of its own");
    } else {
      rotations_.reset(elements());
      for (std::size_t e = 0; e < elements(); ++e) {
        if (solid[e] != 0) rotations_.set(e, rotation_of(mean_displacement_gradient(e, u)));
      }
    }
  }
  void set_taking_part(std::span<const char> elements) override {
    taking_part_.assign(elements.begin(), elements.end());
  }
  std::size_t elements() const override { return std::size_t(geometry_.elements()); }
  std::size_t points() const override { return of_element; }
  /// Gradients and weights of the elements.
  const fem::ElementGeometry<Element>& geometry() const { return geometry_; }

  void strains(ElementBlock block, std::span<const double> u, TensorBlock<dimension> deviator,
               std::span<double> dilatation) const override {
    with_lanes([&]<int Count>() {
      for (std::size_t e = block.first; e < block.end; e += Count) {
        const auto& cells = geometry_.template group<Count>(e);
        const auto v = gather<Count>(e, block.end, u);
        const std::size_t i = e - block.first;
        store<Count>(FormsOfSeveral<Count>::mean_dilatation(cells, v), &dilatation[i]);
        const auto of_cells = FormsOfSeveral<Count>::strain_deviators(cells, v);
        for (std::size_t q = 0; q < of_element; ++q) {
          deviator.template store<Count>(place_in_block(i, q), of_cells[q]);
        }
      }
    });
  }

  void add_forces(ElementBlock block, TensorBlock<dimension> stress,
                  std::span<const double> pressure, std::span<double> force,
                  double& squares) const override {
    with_lanes([&]<int Count>() {
      for (std::size_t e = block.first; e < block.end; e += Count) {
        typename FormsOfSeveral<Count>::Tensors deviator;
        typename FormsOfSeveral<Count>::Pressures mean;
        for (std::size_t q = 0; q < of_element; ++q) {
          const std::size_t place = place_in_block(e - block.first, q);
          deviator[q] = stress.template load<Count>(place);
          mean[q] = load<Count>(&pressure[place]);
        }
        const auto f =
            FormsOfSeveral<Count>::forces(geometry_.template group<Count>(e), deviator, mean);
        scatter<Count>(e, block.end, f, force, squares);
      }
    });
  }

  void add_stiffness(ElementBlock block, ResponseBlock<dimension> response,
                     std::span<const double> bulk, const linalg::SparsityPattern& pattern,
                     std::span<double> values) const override {
    with_lanes([&]<int Count>() {
      for (std::size_t e = block.first; e < block.end; e += Count) {
        const std::size_t i = e - block.first;
        typename FormsOfSeveral<Count>::Responses of_cells;
        for (std::size_t q = 0; q < of_element; ++q) {
          of_cells[q] = response.template load<Count>(place_in_block(i, q));
        }
        const auto k = FormsOfSeveral<Count>::stiffness(geometry_.template group<Count>(e),
                                                        of_cells, load<Count>(&bulk[i]));
        add_matrices<Count>(e, block.end, k, pattern, values);
      }
    });
  }

  typename Base::PointTensors strains(std::size_t e, std::span<const double> u) const override {
    const auto of_cell = Forms::strains(cell_of(e), local(e, u));
    typename Base::PointTensors strains{};
    std::copy(of_cell.begin(), of_cell.end(), strains.begin());
    return strains;
  }
  double mean_dilatation(std::size_t e, std::span<const double> u) const override {
    return Forms::mean_dilatation(geometry_.mean_gradient(static_cast<int>(e)), local(e, u));
  }

  double volume(std::size_t e) const override { return geometry_.volume(static_cast<int>(e)); }

  /// Sum over the elements of |p grad N|^2 V^2, the squares of the forces of a mean stress p.
  double squared_forces(std::span<const double> stress) const override {
    double sum = 0.0;
    with_lanes([&]<int Count>() {
      for (std::size_t e = 0; e < stress.size(); e += Count) {
        const auto& cells = geometry_.template group<Count>(e);
        Lanes<Count> squares{};
        for (const auto& gradient : cells.mean_gradient) {
          for (const auto& g : gradient) squares += g * g;
        }
        squares *= cells.volume * cells.volume;
        for (std::size_t of = e; of < std::min(e + Count, stress.size()); ++of) {
          if (takes_part(of)) sum += stress[of] * stress[of] * squares[of - e];
        }
      }
    });
    return sum;
  }

  double subtract_weight(std::span<const double> specific_weight,
                         std::span<double> force) const override {
    double whole = 0.0;
    with_lanes([&]<int Count>() {
      for (std::size_t e = 0; e < specific_weight.size(); e += Count) {
        const auto& cells = geometry_.template group<Count>(e);
        // Each node carries the weight of its share of the element's volume.
        const auto share = node_volumes<Count>(cells);
        for (std::size_t of = e; of < std::min(e + Count, specific_weight.size()); ++of) {
          whole += specific_weight[of] * cells.volume[of - e];
          for (std::size_t i = 0; i < nodes; ++i) {
            frames_.lower(force, nodes_of(of)[i], specific_weight[of] * share[i][of - e]);
          }
        }
      }
    });
    return whole;
  }

  double add_pressure(const mesh::Facet<dimension>& facet, std::span<const double> pressure,
                      std::span<double> force) const override {
    const auto of_facet = fem::pressure_forces<Element>(*mesh_, facet, pressure);
    double upward = 0.0;
    for (std::size_t i = 0; i < std::size_t(facet.nodes); ++i) {
      frames_.add(force, facet.node[i], of_facet[i]);
      upward += of_facet[i][dim - 1];
    }
    return upward;
  }

  fem::FacetShares<dimension> facet_shares(const mesh::Facet<dimension>& facet) const override {
    return fem::facet_shares_of<Element>(*mesh_, facet);
  }

private:
  bool takes_part(std::size_t e) const { return taking_part_.empty() || taking_part_[e] != 0; }
  auto cell_of(std::size_t e) const { return geometry_.cell(static_cast<int>(e)); }
  const int* nodes_of(std::size_t e) const { return mesh_->nodes_of(static_cast<int>(e)); }

  /// Displacements of the nodes of an element along the coordinate axes.
  Vectors nodal(std::size_t e, std::span<const double> u) const {
    const int* node = nodes_of(e);
    Vectors v;
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) v[i][a] = u[std::size_t(node[i]) * dim + a];
    }
    if (frames_.has_frame(e)) frames_.to_coordinates(node, v);
    return v;
  }
  /// The same in the rotated axes of the element.
  Vectors local(std::size_t e, std::span<const double> u) const {
    Vectors v = nodal(e, u);
    if (rotations_.has_rotation(e)) rotations_.into_element(e, *mesh_, v);
    return v;
  }
  /// Mean over the element of grad u, in the coordinate axes [1].
  typename Rotations::Matrix mean_displacement_gradient(std::size_t e,
                                                        std::span<const double> u) const {
    const auto gradient = geometry_.mean_gradient(static_cast<int>(e));
    const Vectors v = nodal(e, u);
    typename Rotations::Matrix of_mean{};
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) {
        for (std::size_t b = 0; b < dim; ++b) of_mean[a][b] += v[i][a] * gradient[i][b];
      }
    }
    return of_mean;
  }

  /// Integrals of the shape functions over the elements of a group.
  template <int Count>
  static auto node_volumes(const fem::ElementCell<Element, Lanes<Count>>& cells) {
    std::array<Lanes<Count>, nodes> share{};
    for (std::size_t q = 0; q < of_element; ++q) {
      const auto shape = Element::shape(Element::point[q]);
      for (std::size_t i = 0; i < nodes; ++i) share[i] += shape[i] * cells.point[q].weight;
    }
    return share;
  }

  /// Displacements of a group of elements; lanes beyond the last element repeat it.
  template <int Count>
  auto gather(std::size_t first, std::size_t end, std::span<const double> u) const {
    std::array<Vectors, Count> of_one;
    for (std::size_t lane = 0; lane < Count; ++lane) {
      of_one[lane] = local(std::min(first + lane, end - 1), u);
    }
    typename FormsOfSeveral<Count>::Vectors v;
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) {
        v[i][a] = lanes_of<Count>([&](std::size_t lane) { return of_one[lane][i][a]; });
      }
    }
    return v;
  }

  /// Adds the forces of a group to the nodes, lane by lane in the order of the elements.
  /// @param f        (node, direction) forces in the elements' axes
  /// @param squares  sum to which the squares of all components are added
  template <int Count>
  void scatter(std::size_t first, std::size_t end, const typename FormsOfSeveral<Count>::Vectors& f,
               std::span<double> force, double& squares) const {
    Lanes<Count> square{};
    for (const auto& of_node : f) {
      for (const auto& component : of_node) square += component * component;
    }
    for (std::size_t e = first; e < std::min(first + Count, end); ++e) {
      if (!takes_part(e)) continue;
      Vectors of_one;
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) of_one[i][a] = f[i][a][e - first];
      }
      add_force(e, of_one, force);
      squares += square[e - first];
    }
  }
  /// Adds the forces of an element, after turning them to the coordinate axes and to nodal frames.
  void add_force(std::size_t e, Vectors& f, std::span<double> force) const {
    const int* node = nodes_of(e);
    if (rotations_.has_rotation(e)) rotations_.out_of_element(e, f);
    if (frames_.has_frame(e)) frames_.to_frames(node, f);
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) force[std::size_t(node[i]) * dim + a] += f[i][a];
    }
  }

  /// Adds the matrices of a group, lane by lane in the order of the elements.
  template <int Count>
  void add_matrices(std::size_t first, std::size_t end,
                    const typename FormsOfSeveral<Count>::Matrix& k,
                    const linalg::SparsityPattern& pattern, std::span<double> values) const {
    for (std::size_t e = first; e < std::min(first + Count, end); ++e) {
      if (!takes_part(e)) continue;
      Matrix of_one;
      for (std::size_t r = 0; r < unknowns; ++r) {
        for (std::size_t s = 0; s <= r; ++s) {
          of_one[r * unknowns + s] = k[r * unknowns + s][e - first];
        }
      }
      add_matrix(e, of_one, pattern, values);
    }
  }
  /// Adds the matrix of an element, given by its lower triangle, at its places in the pattern.
  void add_matrix(std::size_t e, Matrix& k, const linalg::SparsityPattern& pattern,
                  std::span<double> values) const {
    if (rotations_.has_rotation(e)) rotations_.template out_of_element<nodes>(e, k);
    if (frames_.has_frame(e)) frames_.template to_frames<nodes>(nodes_of(e), k);
    const int* place = pattern.places(static_cast<int>(e));
    for (std::size_t r = 0; r < unknowns; ++r) {
      for (std::size_t s = 0; s <= r; ++s) {
        values[std::size_t(place[r * unknowns + s])] += k[r * unknowns + s];
      }
    }
  }

  const Mesh* mesh_ = nullptr;
  NodeFrames<dimension> frames_;
  Rotations rotations_;
  std::vector<char> taking_part_;  ///< (element) @see set_taking_part()
  fem::ElementGeometry<Element> geometry_;
};

}  // namespace dccast::mechanics
