#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/material/norton_hoff.hpp"
#include "core/material/yosida.hpp"
#include "core/mechanics/bending_forms.hpp"
#include "core/mechanics/element_forms.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// Internal forces and stiffness of a step problem, over one streaming pass through the elements.
template <class Element>
class Equilibrium {
public:
  static constexpr int dimension = Element::dimension;
  using Tensor = SymmetricTensor<dimension>;
  using Response = PointResponse<dimension>;

  explicit Equilibrium(const StepProblem<Element>& problem) : problem_(&problem) {
    response_.resize(std::size_t(problem.geometry->elements()) * Element::points);
  }

  /// residual = internal force - external force at displacement `u`; remembers the response of every
  /// point for `tangent`. A law is called as law(element, point, trial strain deviator) -> Response.
  /// @return root of the sum of squares of all element forces: the forces that act, before they
  ///         cancel, against which a residual is small or not
  template <class Law>
  double residual(std::span<const double> u, std::span<double> out, Law&& law) {
    const StepProblem<Element>& p = *problem_;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = -p.external_force[i];
    double acting = 0.0;
    for (int e = 0; e < p.geometry->elements(); ++e) {
      const auto force = element_force(e, u, law);
      const int* node = p.mesh->nodes_of(e);
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) {
          acting += force[i][a] * force[i][a];
          out[std::size_t(node[i]) * dim + a] += force[i][a];
        }
      }
    }
    return std::sqrt(acting);
  }

  /// Stiffness at the last residual. @param values  the pattern's entries, overwritten
  void tangent(std::span<double> values) const;

  const std::vector<Response>& response() const { return response_; }
  /// Strain of a displacement at a point, its trace replaced by the element's mean dilatation.
  static Tensor strain_of(const typename fem::ElementGeometry<Element>::Cell& cell,
                          std::size_t point, const int* node, std::span<const double> u) {
    return Forms::strain(cell, point, local(node, u));
  }
  /// Mean normal stress of an element at displacement `u` [Pa].
  double pressure(int element, std::span<const double> u) const {
    const Vectors v = local(problem_->mesh->nodes_of(element), u);
    return pressure_of(element, Forms::mean_dilatation(cell(element), v), 0);
  }

private:
  static constexpr std::size_t nodes = Element::nodes, points = Element::points,
                               dim = Element::dimension;
  using Forms = ElementForms<Element>;
  using Vectors = typename Forms::Vectors;

  const typename Forms::Cell& cell(int e) const { return problem_->geometry->cell(e); }

  static Vectors local(const int* node, std::span<const double> u) {
    Vectors v;
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) v[i][a] = u[std::size_t(node[i]) * dim + a];
    }
    return v;
  }

  double pressure_of(int e, double dilatation, std::size_t point) const {
    const StepProblem<Element>& p = *problem_;
    const std::size_t i = std::size_t(e);
    return p.bulk[i] * (dilatation - p.inelastic[i * points + point].trace() - 3.0 * p.thermal[i]) +
           p.prestress[i];
  }

  template <class Law>
  Vectors element_force(int e, std::span<const double> u, Law&& law) {
    const auto& c = cell(e);
    const Vectors v = local(problem_->mesh->nodes_of(e), u);
    const double dilatation = Forms::mean_dilatation(c, v);
    typename Forms::Tensors trial = Forms::strain_deviators(c, v);
    typename Forms::Pressures pressure;
    Response* response = &response_[std::size_t(e) * points];
    for (std::size_t q = 0; q < points; ++q) {
      const std::size_t index = std::size_t(e) * points + q;
      trial[q].add(-1.0, problem_->inelastic[index].deviator());
      response[q] = law(std::size_t(e), index, trial[q]);
      pressure[q] = pressure_of(e, dilatation, q);
    }
    return Forms::forces(
        c, [response](std::size_t q) -> const Tensor& { return response[q].deviator; }, pressure);
  }

  const StepProblem<Element>* problem_;
  std::vector<Response> response_;
};

template <class Element>
void Equilibrium<Element>::tangent(std::span<double> values) const {
  const StepProblem<Element>& p = *problem_;
  std::fill(values.begin(), values.end(), 0.0);
  constexpr std::size_t size = nodes * dim;
  for (int e = 0; e < p.geometry->elements(); ++e) {
    const std::span response(&response_[std::size_t(e) * points], points);
    const auto k = Forms::stiffness(cell(e), response, p.bulk[std::size_t(e)]);
    const int* place = p.pattern->places(e);
    for (std::size_t r = 0; r < size; ++r) {
      for (std::size_t s = 0; s <= r; ++s) {
        values[std::size_t(place[r * size + s])] += k[r * size + s];
      }
    }
  }
}

}  // namespace dccast::mechanics
