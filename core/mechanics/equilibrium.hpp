#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "core/material/norton_hoff.hpp"
#include "core/material/yosida.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// Internal forces and stiffness of a step problem, over one streaming pass through the elements.
template <int Dim>
class Equilibrium {
public:
  using Tensor = SymmetricTensor<Dim>;
  using Response = PointResponse<Dim>;

  explicit Equilibrium(const StepProblem<Dim>& problem)
      : problem_(&problem),
        points_(problem.forms->points()),
        response_(problem.forms->elements() * points_),
        trial_(elements_in_block * points_),
        pressure_(elements_in_block * points_) {}

  /// residual = internal force - external force at displacement `u`; remembers the response of every
  /// point for `tangent`. A law is called as law(element, point, trial strain deviator) -> Response.
  /// @return root of the sum of squares of all element forces: the forces that act, before they
  ///         cancel, against which a residual is small or not
  template <class Law>
  double residual(std::span<const double> u, std::span<double> out, Law&& law) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = -problem_->external_force[i];
    double squares = 0.0;
    for_each_block([&](ElementBlock block) {
      problem_->forms->strains(block, u, trial_, dilatation_);
      for (std::size_t e = block.first; e < block.end; ++e) respond(block, e, law);
      problem_->forms->add_forces(block, responses_of(block), pressure_, out, squares);
    });
    for (std::size_t i = 0; i < problem_->spring.size(); ++i) {
      const double force = problem_->spring[i] * u[i];
      out[i] += force;
      squares += force * force;
    }
    return std::sqrt(squares);
  }

  /// Stiffness at the last residual. @param values  the pattern's entries, overwritten
  void tangent(std::span<double> values) const {
    std::fill(values.begin(), values.end(), 0.0);
    for_each_block([&](ElementBlock block) {
      problem_->forms->add_stiffness(block, responses_of(block),
                                     std::span(problem_->bulk).subspan(block.first),
                                     *problem_->pattern, values);
    });
    for (std::size_t i = 0; i < problem_->spring.size(); ++i) {
      values[std::size_t(problem_->pattern->diagonal(static_cast<int>(i)))] += problem_->spring[i];
    }
  }

  const std::vector<Response>& response() const { return response_; }
  /// Mean normal stress of an element at displacement `u` [Pa].
  double pressure(int element, std::span<const double> u) const {
    const std::size_t e = std::size_t(element);
    return pressure_of(e, problem_->forms->mean_dilatation(e, u), e * points_);
  }

private:
  template <class Use>
  void for_each_block(Use&& use) const {
    const std::size_t elements = problem_->forms->elements();
    for (std::size_t first = 0; first < elements; first += elements_in_block) {
      use(ElementBlock{first, std::min(first + elements_in_block, elements)});
    }
  }

  std::span<const Response> responses_of(ElementBlock block) const {
    return std::span(response_).subspan(block.first * points_, block.elements() * points_);
  }

  /// Stress of the points of an element, from the strains of its block.
  template <class Law>
  void respond(ElementBlock block, std::size_t e, Law&& law) {
    for (std::size_t q = 0; q < points_; ++q) {
      const std::size_t in_block = (e - block.first) * points_ + q, index = e * points_ + q;
      Tensor& trial = trial_[in_block];
      trial.add(-1.0, problem_->inelastic[index].deviator());
      response_[index] = law(e, index, trial);
      pressure_[in_block] = pressure_of(e, dilatation_[e - block.first], index);
    }
  }

  double pressure_of(std::size_t e, double dilatation, std::size_t point) const {
    const StepProblem<Dim>& p = *problem_;
    return p.bulk[e] * (dilatation - p.inelastic[point].trace() - 3.0 * p.thermal[e]) +
           p.prestress[e];
  }

  const StepProblem<Dim>* problem_;
  std::size_t points_;  ///< of an element
  std::vector<Response> response_;
  // Of the block under way.
  std::vector<Tensor> trial_;
  std::vector<double> pressure_;
  std::array<double, elements_in_block> dilatation_;
};

}  // namespace dccast::mechanics
