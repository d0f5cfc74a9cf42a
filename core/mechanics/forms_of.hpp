#pragma once

#include "core/mechanics/bending_forms.hpp"
#include "core/mechanics/element_forms.hpp"
#include "core/mechanics/mechanics_forms.hpp"
#include "core/mechanics/node_frames.hpp"
#include "core/mechanics/solid_bending_forms.hpp"

namespace dccast::mechanics {

/// The forms of a mesh of one kind of element: gathers from and scatters to the nodes around
/// ElementForms.
template <class Element>
class FormsOf final : public MechanicsForms<Element::dimension> {
  using Base = MechanicsForms<Element::dimension>;
  using Forms = ElementForms<Element>;
  using Vectors = typename Forms::Vectors;
  static constexpr std::size_t nodes = Forms::nodes, dim = Forms::dim, of_element = Forms::points,
                               unknowns = Forms::unknowns;

public:
  using typename Base::Mesh, typename Base::Response, typename Base::Tensor;

  void update(const Mesh& mesh, std::size_t first = 0) override {
    mesh_ = &mesh;
    if (mesh.elements() != geometry_.elements()) frames_ = {};
    geometry_.update(mesh, static_cast<int>(first));
  }
  void set_frames(std::span<const NodalFrame<Element::dimension>> frames) override {
    frames_.set(*mesh_, frames);
  }
  std::size_t elements() const override { return std::size_t(geometry_.elements()); }
  std::size_t points() const override { return of_element; }
  const fem::ElementGeometry<Element>& geometry() const { return geometry_; }

  void strains(ElementBlock block, std::span<const double> u, std::span<Tensor> deviator,
               std::span<double> dilatation) const override {
    for (std::size_t e = block.first; e < block.end; ++e) {
      const std::size_t i = e - block.first;
      const auto& cell = cell_of(e);
      const Vectors v = local(e, u);
      dilatation[i] = Forms::mean_dilatation(cell, v);
      const auto of_cell = Forms::strain_deviators(cell, v);
      std::copy(of_cell.begin(), of_cell.end(), deviator.begin() + long(i * of_element));
    }
  }

  void add_forces(ElementBlock block, std::span<const Response> response,
                  std::span<const double> pressure, std::span<double> force,
                  double& squares) const override {
    for (std::size_t e = block.first; e < block.end; ++e) {
      const std::size_t at = (e - block.first) * of_element;
      Vectors f = Forms::forces(cell_of(e), response.subspan(at).template first<of_element>(),
                                pressure.subspan(at).template first<of_element>());
      const int* node = nodes_of(e);
      if (frames_.touch(e)) frames_.to_frames(node, f);
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) {
          squares += f[i][a] * f[i][a];
          force[std::size_t(node[i]) * dim + a] += f[i][a];
        }
      }
    }
  }

  void add_stiffness(ElementBlock block, std::span<const Response> response,
                     std::span<const double> bulk, const linalg::SparsityPattern& pattern,
                     std::span<double> values) const override {
    for (std::size_t e = block.first; e < block.end; ++e) {
      const std::size_t i = e - block.first;
      auto k = Forms::stiffness(
          cell_of(e), response.subspan(i * of_element).template first<of_element>(), bulk[i]);
      if (frames_.touch(e)) frames_.template to_frames<nodes>(nodes_of(e), k);
      const int* place = pattern.places(static_cast<int>(e));
      for (std::size_t r = 0; r < unknowns; ++r) {
        for (std::size_t s = 0; s <= r; ++s) {
          values[std::size_t(place[r * unknowns + s])] += k[r * unknowns + s];
        }
      }
    }
  }

  Tensor strain(std::size_t e, std::size_t point, std::span<const double> u) const override {
    return Forms::strain(cell_of(e), point, local(e, u));
  }
  double mean_dilatation(std::size_t e, std::span<const double> u) const override {
    return Forms::mean_dilatation(cell_of(e), local(e, u));
  }

  double volume(std::size_t e) const override { return cell_of(e).volume; }

  double squared_forces(std::span<const double> stress) const override {
    double sum = 0.0;
    for (std::size_t e = 0; e < stress.size(); ++e) {
      const double force = cell_of(e).volume * stress[e];
      for (const auto& gradient : cell_of(e).mean_gradient) {
        for (const double g : gradient) sum += force * force * g * g;
      }
    }
    return sum;
  }

  double subtract_weight(std::span<const double> specific_weight,
                         std::span<double> force) const override {
    double whole = 0.0;
    for (std::size_t e = 0; e < specific_weight.size(); ++e) {
      const int* node = nodes_of(e);
      for (std::size_t q = 0; q < of_element; ++q) {
        const auto shape = Element::shape(Element::point[q]);
        const double weight = specific_weight[e] * cell_of(e).point[q].weight;
        whole += weight;
        for (std::size_t i = 0; i < nodes; ++i) frames_.lower(force, node[i], shape[i] * weight);
      }
    }
    return whole;
  }

  fem::FacetShares<Element::dimension> facet_shares(
      const mesh::Facet<Element::dimension>& facet) const override {
    return fem::facet_shares_of<Element>(*mesh_, facet);
  }

private:
  const auto& cell_of(std::size_t e) const { return geometry_.cell(static_cast<int>(e)); }
  const int* nodes_of(std::size_t e) const { return mesh_->nodes_of(static_cast<int>(e)); }

  Vectors local(std::size_t e, std::span<const double> u) const {
    const int* node = nodes_of(e);
    Vectors v;
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) v[i][a] = u[std::size_t(node[i]) * dim + a];
    }
    if (frames_.touch(e)) frames_.to_coordinates(node, v);
    return v;
  }

  const Mesh* mesh_ = nullptr;
  NodeFrames<Element::dimension> frames_;
  fem::ElementGeometry<Element> geometry_;
};

}  // namespace dccast::mechanics
