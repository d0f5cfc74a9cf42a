#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <type_traits>
#include <vector>

#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// Size of the round-off error in a nodal force [N/m in 2D, N in 3D].
///
/// The stress-free strains, thermal and inelastic, cancel against those of the displacement; the
/// cancellation loses this much. For a body without stress and weight it is the only force scale
/// there is.
template <int Dim>
double round_off_force(const StepProblem<Dim>& problem) {
  constexpr double operations = 16.0;  // [1] roundings on the way from a strain to its nodal force
  const std::size_t points = problem.forms->points();
  std::vector<double> stress(problem.bulk.size());  // (element) stress that cancels [Pa]
  for (std::size_t e = 0; e < stress.size(); ++e) {
    double strain = 3.0 * std::abs(problem.thermal[e]);
    for (std::size_t q = 0; q < points; ++q) {
      strain = std::max(strain, problem.inelastic[e * points + q].norm());
    }
    stress[e] = (problem.bulk[e] + 2.0 * problem.shear[e]) * strain;
  }
  return operations * std::numeric_limits<double>::epsilon() *
         std::sqrt(problem.forms->squared_forces(stress));
}

/// Smallest force against which a residual is judged [N/m in 2D, N in 3D]: the weight or other
/// applied forces; if there are none, the force with which a residual of round-off size passes the
/// tolerance.
/// @param round_off  round_off_force() of the problem [N/m in 2D, N in 3D]
/// @param tolerance  of the relative residual [1]
template <int Dim>
double least_acting_force(const StepProblem<Dim>& problem, double round_off, double tolerance) {
  double applied = 0.0;
  for (const double f : problem.external_force) applied += f * f;
  return std::max({problem.weight, std::sqrt(applied), round_off / tolerance,
                   std::numeric_limits<double>::min()});
}

/// Internal forces and stiffness of a step problem, computed in one streaming pass through the
/// elements, which the team lent to the calling thread shares.
///
/// Units: displacements [m]; forces [N/m] in 2D, [N/rad] if axisymmetric, [N] in 3D.
template <int Dim>
class Equilibrium {
public:
  using Tensor = SymmetricTensor<Dim>;

  /// Lays out the blocks and takes the stress-free strains from the problem, which must not change
  /// while this object is used.
  explicit Equilibrium(const StepProblem<Dim>& problem)
      : problem_(&problem),
        points_(problem.forms->points()),
        places_(elements_in_block * points_),
        blocks_((problem.forms->elements() + elements_in_block - 1) / elements_in_block),
        response_(blocks_ * places_ * ResponseBlock<Dim>::numbers),
        inelastic_(blocks_ * places_ * (Tensor::components + 1)),
        bulk_(problem.bulk),
        whole_(problem.forms->elements()) {
    for_each_block([this](ElementBlock block) { take_inelastic(block); });
  }

  /// residual = internal force - external force at displacement `u`; stores the response of every
  /// point for tangent(). A law is called as law(block, trial strain deviators, responses to fill
  /// in), or as law(element, point, trial strain deviator) -> PointResponse.
  /// @return root of the sum of squares of all element forces before they cancel at the nodes: the
  ///         scale against which a residual is judged
  template <class Law>
  double residual(std::span<const double> u, std::span<double> out, Law&& law) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = -problem_->external_force[i];
    // Sums are kept by part and added in order, so that the result does not depend on the threads.
    std::vector<double> squares_of(parts().parts(), 0.0);
    const auto add_part = [&](std::size_t part, std::size_t first, std::size_t end) {
      squares_of[part] = add_blocks(first, end, u, out, law);
    };
    if constexpr (by_block<Law>) {
      parts().for_each(add_part);
    } else {
      const Team::Lent none(nullptr);  // such a law may have state: call it from one thread only
      parts().for_each(add_part);
    }
    double squares = std::accumulate(squares_of.begin(), squares_of.end(), 0.0);
    for (std::size_t i = 0; i < problem_->spring.size(); ++i) {
      const double force = problem_->spring[i] * (u[i] - problem_->target[i]);
      out[i] += force;
      squares += force * force;
    }
    return std::sqrt(squares);
  }

  /// Stiffness at the displacement of the last residual().
  /// @param values  (entry of the pattern) [force/m], overwritten
  void tangent(std::span<double> values) {
    for_each_stretch(values.size(), numbers_worth_a_call, [&](std::size_t first, std::size_t end) {
      std::fill(values.begin() + std::ptrdiff_t(first), values.begin() + std::ptrdiff_t(end), 0.0);
    });
    for_each_block([&](ElementBlock block) {
      problem_->forms->add_stiffness(block, response_of(block), of_block(block, bulk_),
                                     *problem_->pattern, values);
    });
    for (std::size_t i = 0; i < problem_->spring.size(); ++i) {
      values[std::size_t(problem_->pattern->diagonal(static_cast<int>(i)))] += problem_->spring[i];
    }
  }

  /// Stress deviator at the displacement of the last residual() [Pa].
  /// @param point  element times the points of an element plus point in it
  Tensor deviator(std::size_t point) const {
    const std::size_t e = point / points_, block = e / elements_in_block;
    const std::size_t place = place_in_block(e % elements_in_block, point % points_);
    const double* number = &response_[block * places_ * ResponseBlock<Dim>::numbers];
    Tensor s;
    for (std::size_t c = 0; c < Tensor::components; ++c) s[c] = number[c * places_ + place];
    return s;
  }
  /// The same for all points.
  std::vector<Tensor> deviators() const {
    std::vector<Tensor> all(problem_->inelastic.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = deviator(i);
    return all;
  }

private:
  static constexpr std::size_t numbers_worth_a_call = 50'000;  // some 10 us of one thread

  /// Work arrays of a block in residual().
  struct Passing {
    /// @param places  elements_in_block times the points of an element
    explicit Passing(std::size_t places)
        : deviator(places * Tensor::components), pressure(places) {}
    /// The trial strain deviators as a law takes them.
    TensorBlock<Dim> trial() { return {deviator.data(), pressure.size()}; }
    /// (component, place) trial strain deviators [1].
    std::vector<double> deviator;
    /// (place) mean normal stresses [Pa].
    std::vector<double> pressure;
    /// (element of the block) mean dilatations [1].
    std::array<double, elements_in_block> dilatation{};
  };
  /// Whether a law takes a whole block; otherwise it is called point by point.
  template <class Law>
  static constexpr bool by_block =
      std::is_invocable_v<Law, ElementBlock, TensorBlock<Dim>, ResponseBlock<Dim>>;

  /// Parts of the problem, or all elements as one part.
  const ElementParts& parts() const { return problem_->parts ? *problem_->parts : whole_; }
  /// Calls use(block) for every block, in parts that the team divides.
  template <class Use>
  void for_each_block(const Use& use) const {
    parts().for_each([&](std::size_t, std::size_t first, std::size_t end) {
      for (std::size_t b = first; b < end; ++b) use(block_of(b * elements_in_block));
    });
  }
  /// Internal forces of consecutive blocks. @return sum of the squares of their elements' forces
  template <class Law>
  double add_blocks(std::size_t first, std::size_t end, std::span<const double> u,
                    std::span<double> out, Law&& law) {
    Passing passing(places_);
    double squares = 0.0;
    for (std::size_t b = first; b < end; ++b) {
      const ElementBlock block = block_of(b * elements_in_block);
      problem_->forms->strains(block, u, passing.trial(), passing.dilatation);
      subtract_inelastic(block, passing);
      respond(block, passing.trial(), law);
      problem_->forms->add_forces(block, response_of(block).deviator, passing.pressure, out,
                                  squares);
    }
    return squares;
  }
  /// The block that an element belongs to. The last one may be partly filled.
  ElementBlock block_of(std::size_t element) const {
    const std::size_t first = element / elements_in_block * elements_in_block;
    return {first, std::min(first + elements_in_block, problem_->forms->elements())};
  }
  /// Where the responses of a block are kept between residual() and tangent().
  ResponseBlock<Dim> response_of(ElementBlock block) {
    const std::size_t number = block.first / elements_in_block;
    return {&response_[number * places_ * ResponseBlock<Dim>::numbers], places_};
  }
  /// Deviators of the inelastic strains of a block, followed by the stress-free dilatation of each
  /// place [1].
  double* inelastic_of(ElementBlock block) {
    const std::size_t number = block.first / elements_in_block;
    return &inelastic_[number * places_ * (Tensor::components + 1)];
  }

  /// Copies the inelastic strains of a block from the problem, in the order of its places.
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

  /// Computes trial deviators and pressures at the points of a block from its strains.
  void subtract_inelastic(ElementBlock block, Passing& passing) {
    // trial = deviator of the strain less that of the stress-free strain; p = bulk (tr - tr_0) +
    // prestress
    std::vector<double>& trial = passing.deviator;
    const double* inelastic = inelastic_of(block);
    for (std::size_t i = 0; i < trial.size(); ++i) trial[i] -= inelastic[i];
    const double* inelastic_dilatation = inelastic + trial.size();
    const auto bulk = of_block(block, problem_->bulk);
    const auto prestress = of_block(block, problem_->prestress);
    for (std::size_t q = 0; q < points_; ++q) {
      for (std::size_t i = 0; i < elements_in_block; ++i) {
        const std::size_t place = place_in_block(i, q);
        passing.pressure[place] =
            bulk[i] * (passing.dilatation[i] - inelastic_dilatation[place]) + prestress[i];
      }
    }
    relax_mush(block, passing);
  }

  /// Volumetric creep of the elements that are mush; few are, so they are treated one by one. The
  /// mean stress is the same at all points of an element.
  void relax_mush(ElementBlock block, Passing& passing) {
    if (problem_->volumetric_kappa.empty()) return;
    for (std::size_t e = block.first; e < block.end; ++e) {
      if (problem_->volumetric_kappa[e] <= 0.0) continue;
      const std::size_t i = e - block.first;
      const auto relaxed =
          relaxed_mean_stress(*problem_, e, passing.pressure[place_in_block(i, 0)]);
      for (std::size_t q = 0; q < points_; ++q)
        passing.pressure[place_in_block(i, q)] = relaxed.stress;
      bulk_[e] = relaxed.tangent;
    }
  }

  /// Fills in the responses of a block, from trial strain deviators [1].
  template <class Law>
  void respond(ElementBlock block, TensorBlock<Dim> trial, Law&& law) {
    const ResponseBlock<Dim> response = response_of(block);
    if constexpr (by_block<Law>) {
      law(block, trial, response);
    } else {
      for (std::size_t e = block.first; e < block.end; ++e) {
        for (std::size_t q = 0; q < points_; ++q) {
          const std::size_t place = place_in_block(e - block.first, q);
          response.set(place, law(e, e * points_ + q, trial.at(place)));
        }
      }
    }
  }

  const StepProblem<Dim>* problem_;
  std::size_t points_;  ///< of an element
  std::size_t places_;  ///< of a block
  std::size_t blocks_;
  std::vector<double> response_;   ///< (block) @see ResponseBlock
  std::vector<double> inelastic_;  ///< (block) @see inelastic_of
  std::vector<double> bulk_;       ///< (element) tangent dp / d tr of the last residual() [Pa]
  ElementParts whole_;             ///< used if the problem specifies no parts
};

/// Mean normal stress of an element at displacement `u` [Pa].
template <int Dim>
double mean_normal_stress(const StepProblem<Dim>& p, int element, std::span<const double> u) {
  const std::size_t e = std::size_t(element);
  const double inelastic = p.inelastic[e * p.forms->points()].trace() + 3.0 * p.thermal[e];
  const double trial = p.bulk[e] * (p.forms->mean_dilatation(e, u) - inelastic) + p.prestress[e];
  return relaxed_mean_stress(p, e, trial).stress;
}

}  // namespace dccast::mechanics
