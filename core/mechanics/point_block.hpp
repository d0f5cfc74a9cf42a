#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/base/lanes.hpp"
#include "core/base/symmetric_tensor.hpp"

namespace dccast::mechanics {

/// Elements first to end - 1. Work goes by blocks, small enough for the cache, so that a call costs
/// nothing beside the work.
struct ElementBlock {
  std::size_t first = 0, end = 0;
  std::size_t elements() const { return end - first; }
};
inline constexpr std::size_t elements_in_block = 64;
static_assert(elements_in_block % std::size_t(most_lanes) == 0);

/// Where a point of a block stands among its points: what is contiguous are neighbouring elements,
/// so that formulas work on several at once. A block that is not full has unused places.
/// @param element  within the block
constexpr std::size_t place_in_block(std::size_t element, std::size_t point) {
  return point * elements_in_block + element;
}

/// Symmetric tensors at the points of a block, component by component; a view of their numbers.
template <int Dim>
class TensorBlock {
public:
  using Tensor = SymmetricTensor<Dim>;
  /// @param places  elements_in_block times the points of an element
  TensorBlock(double* numbers, std::size_t places) : numbers_(numbers), places_(places) {}

  std::size_t points() const { return places_ / elements_in_block; }  ///< of an element
  double* component(std::size_t c) const { return numbers_ + c * places_; }
  Tensor at(std::size_t place) const {
    Tensor t;
    for (std::size_t c = 0; c < Tensor::components; ++c) t[c] = component(c)[place];
    return t;
  }
  void set(std::size_t place, const Tensor& t) const {
    for (std::size_t c = 0; c < Tensor::components; ++c) component(c)[place] = t[c];
  }
  /// Of the elements that share a register.
  template <int Count>
  SymmetricTensor<Dim, Lanes<Count>> load(std::size_t place) const {
    SymmetricTensor<Dim, Lanes<Count>> t;
    for (std::size_t c = 0; c < Tensor::components; ++c) {
      t[c] = dccast::load<Count>(component(c) + place);
    }
    return t;
  }
  template <int Count>
  void store(std::size_t place, const SymmetricTensor<Dim, Lanes<Count>>& t) const {
    for (std::size_t c = 0; c < Tensor::components; ++c) {
      dccast::store<Count>(t[c], component(c) + place);
    }
  }

private:
  double* numbers_;
  std::size_t places_;
};

/// What a material law gives at a point: the stress deviator, and the tangent
/// d s / d e = 2 shear I + softening s (x) s.
template <int Dim, class Number = double>
struct PointResponse {
  SymmetricTensor<Dim, Number> deviator;  ///< s [Pa]
  Number shear;                           ///< mu~ [Pa]
  Number softening;                       ///< [1/Pa], not positive
};

/// What a law gives at the points of a block; a view of its numbers.
template <int Dim>
struct ResponseBlock {
  static constexpr std::size_t numbers = SymmetricTensor<Dim>::components + 2;  ///< of a point

  TensorBlock<Dim> deviator;
  double* shear;
  double* softening;

  ResponseBlock(double* first, std::size_t places)
      : deviator(first, places),
        shear(first + SymmetricTensor<Dim>::components * places),
        softening(shear + places) {}

  PointResponse<Dim> at(std::size_t place) const {
    return {deviator.at(place), shear[place], softening[place]};
  }
  void set(std::size_t place, const PointResponse<Dim>& r) const {
    deviator.set(place, r.deviator);
    shear[place] = r.shear;
    softening[place] = r.softening;
  }
  /// Of the elements that share a register.
  template <int Count>
  PointResponse<Dim, Lanes<Count>> load(std::size_t place) const {
    return {deviator.template load<Count>(place), dccast::load<Count>(shear + place),
            dccast::load<Count>(softening + place)};
  }
  template <int Count>
  void store(std::size_t place, const PointResponse<Dim, Lanes<Count>>& r) const {
    deviator.template store<Count>(place, r.deviator);
    dccast::store<Count>(r.shear, shear + place);
    dccast::store<Count>(r.softening, softening + place);
  }
};

/// Numbers of the elements of a block from those of all; places without an element are zero.
inline std::array<double, elements_in_block> of_block(ElementBlock block,
                                                      std::span<const double> of_all) {
  std::array<double, elements_in_block> numbers{};
  for (std::size_t i = 0; i < block.elements(); ++i) numbers[i] = of_all[block.first + i];
  return numbers;
}

}  // namespace dccast::mechanics
