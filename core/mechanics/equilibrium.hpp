#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <type_traits>
#include <vector>

#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// Internal forces and stiffness of a step problem, over one streaming pass through the elements.
template <int Dim>
class Equilibrium {
public:
  using Tensor = SymmetricTensor<Dim>;

  explicit Equilibrium(const StepProblem<Dim>& problem)
      : problem_(&problem),
        points_(problem.forms->points()),
        places_(elements_in_block * points_),
        blocks_((problem.forms->elements() + elements_in_block - 1) / elements_in_block),
        response_(blocks_ * places_ * ResponseBlock<Dim>::numbers),
        inelastic_(blocks_ * places_ * (Tensor::components + 1)),
        trial_(places_ * Tensor::components),
        pressure_(places_) {
    for_each_block([this](ElementBlock block) { take_inelastic(block); });
  }

  /// residual = internal force - external force at displacement `u`; remembers the response of
  /// every point for `tangent`. A law is called as law(block, trial strain deviators, responses to
  /// fill in), or as law(element, point, trial strain deviator) -> PointResponse.
  /// @return root of the sum of squares of all element forces: the forces that act, before they
  ///         cancel, against which a residual is small or not
  template <class Law>
  double residual(std::span<const double> u, std::span<double> out, Law&& law) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = -problem_->external_force[i];
    double squares = 0.0;
    for_each_block([&](ElementBlock block) {
      problem_->forms->strains(block, u, trial(), dilatation_);
      subtract_inelastic(block);
      if constexpr (std::is_invocable_v<Law, ElementBlock, TensorBlock<Dim>, ResponseBlock<Dim>>) {
        law(block, trial(), response_of(block));
      } else {
        respond_point_by_point(block, law);
      }
      problem_->forms->add_forces(block, response_of(block).deviator, pressure_, out, squares);
    });
    for (std::size_t i = 0; i < problem_->spring.size(); ++i) {
      const double force = problem_->spring[i] * u[i];
      out[i] += force;
      squares += force * force;
    }
    return std::sqrt(squares);
  }

  /// Stiffness at the last residual. @param values  the pattern's entries, overwritten
  void tangent(std::span<double> values) {
    std::fill(values.begin(), values.end(), 0.0);
    for_each_block([&](ElementBlock block) {
      problem_->forms->add_stiffness(block, response_of(block), of_block(block, problem_->bulk),
                                     *problem_->pattern, values);
    });
    for (std::size_t i = 0; i < problem_->spring.size(); ++i) {
      values[std::size_t(problem_->pattern->diagonal(static_cast<int>(i)))] += problem_->spring[i];
    }
  }

  /// Stress deviator of the last residual [Pa].
  /// @param point  element times the points of an element plus point in it
  Tensor deviator(std::size_t point) const {
    const std::size_t e = point / points_, block = e / elements_in_block;
    const std::size_t place = place_in_block(e % elements_in_block, point % points_);
    const double* number = &response_[block * places_ * ResponseBlock<Dim>::numbers];
    Tensor s;
    for (std::size_t c = 0; c < Tensor::components; ++c) s[c] = number[c * places_ + place];
    return s;
  }
  /// The same of all points.
  std::vector<Tensor> deviators() const {
    std::vector<Tensor> all(problem_->inelastic.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = deviator(i);
    return all;
  }

private:
  template <class Use>
  void for_each_block(Use&& use) const {
    for (std::size_t b = 0; b < blocks_; ++b) use(block_of(b * elements_in_block));
  }
  ElementBlock block_of(std::size_t element) const {
    const std::size_t first = element / elements_in_block * elements_in_block;
    return {first, std::min(first + elements_in_block, problem_->forms->elements())};
  }
  TensorBlock<Dim> trial() { return {trial_.data(), places_}; }
  ResponseBlock<Dim> response_of(ElementBlock block) {
    const std::size_t number = block.first / elements_in_block;
    return {&response_[number * places_ * ResponseBlock<Dim>::numbers], places_};
  }
  /// Deviators of the inelastic strains of a block; behind them, by place, the dilatation that
  /// carries no stress.
  double* inelastic_of(ElementBlock block) {
    const std::size_t number = block.first / elements_in_block;
    return &inelastic_[number * places_ * (Tensor::components + 1)];
  }

  void take_inelastic(ElementBlock block) {
    const TensorBlock<Dim> deviator(inelastic_of(block), places_);
    double* dilatation = deviator.component(Tensor::components);
    for (std::size_t e = block.first; e < block.end; ++e) {
      for (std::size_t q = 0; q < points_; ++q) {
        const Tensor& strain = problem_->inelastic[e * points_ + q];
        const std::size_t place = place_in_block(e - block.first, q);
        deviator.set(place, strain.deviator());
        dilatation[place] = strain.trace() + 3.0 * problem_->thermal[e];
      }
    }
  }

  /// From the strains of a block its trial deviators and the pressures at its points.
  void subtract_inelastic(ElementBlock block) {
    const double* inelastic = inelastic_of(block);
    for (std::size_t i = 0; i < trial_.size(); ++i) trial_[i] -= inelastic[i];
    const double* inelastic_dilatation = inelastic + trial_.size();
    const auto bulk = of_block(block, problem_->bulk);
    const auto prestress = of_block(block, problem_->prestress);
    for (std::size_t q = 0; q < points_; ++q) {
      for (std::size_t i = 0; i < elements_in_block; ++i) {
        const std::size_t place = place_in_block(i, q);
        pressure_[place] = bulk[i] * (dilatation_[i] - inelastic_dilatation[place]) + prestress[i];
      }
    }
  }

  template <class Law>
  void respond_point_by_point(ElementBlock block, Law&& law) {
    const ResponseBlock<Dim> response = response_of(block);
    for (std::size_t e = block.first; e < block.end; ++e) {
      for (std::size_t q = 0; q < points_; ++q) {
        const std::size_t place = place_in_block(e - block.first, q);
        response.set(place, law(e, e * points_ + q, trial().at(place)));
      }
    }
  }

  const StepProblem<Dim>* problem_;
  std::size_t points_;  ///< of an element
  std::size_t places_;  ///< of a block
  std::size_t blocks_;
  std::vector<double> response_;   ///< (block) @see ResponseBlock
  std::vector<double> inelastic_;  ///< (block) @see inelastic_of
  // Of the block under way.
  std::vector<double> trial_;
  std::vector<double> pressure_;
  std::array<double, elements_in_block> dilatation_{};
};

/// Mean normal stress of an element at displacement `u` [Pa].
template <int Dim>
double mean_normal_stress(const StepProblem<Dim>& p, int element, std::span<const double> u) {
  const std::size_t e = std::size_t(element);
  const double inelastic = p.inelastic[e * p.forms->points()].trace() + 3.0 * p.thermal[e];
  return p.bulk[e] * (p.forms->mean_dilatation(e, u) - inelastic) + p.prestress[e];
}

}  // namespace dccast::mechanics
