#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/instructions.hpp"
#include "core/base/team.hpp"
#include "core/base/tensors.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::mechanics {

/// Elements first to end - 1. Work is done in blocks: small enough for the cache, large enough that
/// the cost of a call does not matter.
struct ElementBlock {
  std::size_t first = 0, end = 0;
  std::size_t elements() const { return end - first; }
};
/// Elements of a block; a multiple of the widest register.
inline constexpr std::size_t elements_in_block = 64;
static_assert(elements_in_block % std::size_t(most_lanes) == 0);

/// Index of a point within a block. Consecutive indices belong to neighbouring elements, so that
/// formulas work on several elements at once. A partly filled block has unused places.
/// @param element  within the block
constexpr std::size_t place_in_block(std::size_t element, std::size_t point) {
  return point * elements_in_block + element;
}

/// View of the symmetric tensors at the points of a block, stored component by component, in any
/// unit.
template <int Dim>
class TensorBlock {
public:
  using Tensor = SymmetricTensor<Dim>;
  /// @param places  elements_in_block times the points of an element
  /// @param numbers [any unit]
  TensorBlock(double* numbers, std::size_t places) : numbers_(numbers), places_(places) {}

  std::size_t points() const { return places_ / elements_in_block; }  ///< of an element
  /// (place) [unit of the tensors]
  double* component(std::size_t c) const { return numbers_ + c * places_; }
  /// Copies the tensor at a place. For code outside the inner loops.
  Tensor at(std::size_t place) const {
    Tensor t;
    for (std::size_t c = 0; c < Tensor::components; ++c) t[c] = component(c)[place];
    return t;
  }
  void set(std::size_t place, const Tensor& t) const {
    for (std::size_t c = 0; c < Tensor::components; ++c) component(c)[place] = t[c];
  }
  /// The tensors of the elements that share a register.
  template <int Count>
  SymmetricTensor<Dim, Lanes<Count>> load(std::size_t place) const {
    SymmetricTensor<Dim, Lanes<Count>> t;
    for (std::size_t c = 0; c < Tensor::components; ++c) {
      t[c] = dccast::load<Count>(component(c) + place);
    }
    return t;
  }
  /// Writes the tensors of the elements that share a register.
  template <int Count>
  void store(std::size_t place, const SymmetricTensor<Dim, Lanes<Count>>& t) const {
    for (std::size_t c = 0; c < Tensor::components; ++c) {
      dccast::store<Count>(t[c], component(c) + place);
    }
  }

private:
  double* numbers_;  ///< (component, place) [any unit]
  std::size_t places_;
};

/// Response of a material law at a point: the stress deviator and the tangent d s / d e = 2 shear I
/// + softening s (x) s.
template <int Dim, class Number = double>
struct PointResponse {
  SymmetricTensor<Dim, Number> deviator;  ///< s [Pa]
  Number shear;                           ///< mu~ [Pa]
  Number softening;                       ///< [1/Pa], not positive
};

/// View of the responses of a law at the points of a block.
template <int Dim>
struct ResponseBlock {
  static constexpr std::size_t numbers =
      SymmetricTensor<Dim>::components + 2;  ///< numbers per point

  TensorBlock<Dim> deviator;
  double* shear;      ///< (place) [Pa]
  double* softening;  ///< (place) [1/Pa]

  /// @param first  (component, place) deviators [Pa], then shear [Pa], then softening [1/Pa]
  ResponseBlock(double* first, std::size_t places)
      : deviator(first, places),
        shear(first + SymmetricTensor<Dim>::components * places),
        softening(shear + places) {}

  /// Response at one place. For laws that are called point by point.
  PointResponse<Dim> at(std::size_t place) const {
    return {deviator.at(place), shear[place], softening[place]};
  }
  void set(std::size_t place, const PointResponse<Dim>& r) const {
    deviator.set(place, r.deviator);
    shear[place] = r.shear;
    softening[place] = r.softening;
  }
  /// The responses of the elements that share a register.
  template <int Count>
  PointResponse<Dim, Lanes<Count>> load(std::size_t place) const {
    return {deviator.template load<Count>(place), dccast::load<Count>(shear + place),
            dccast::load<Count>(softening + place)};
  }
  /// Writes the responses of the elements that share a register.
  template <int Count>
  void store(std::size_t place, const PointResponse<Dim, Lanes<Count>>& r) const {
    deviator.template store<Count>(place, r.deviator);
    dccast::store<Count>(r.shear, shear + place);
    dccast::store<Count>(r.softening, softening + place);
  }
};

/// Copies the values of a block's elements from an array by element [unit of the array]; unused
/// places are zero.
inline std::array<double, elements_in_block> of_block(ElementBlock block,
                                                      std::span<const double> of_all) {
  std::array<double, elements_in_block> numbers{};
  for (std::size_t i = 0; i < block.elements(); ++i) numbers[i] = of_all[block.first + i];
  return numbers;
}

/// Divides the elements of a mesh into consecutive parts of whole blocks. No two even parts share a
/// node, nor do two odd ones: all even parts can add to the nodes concurrently, then all odd ones.
/// The division depends on the mesh only, and so does the order of every sum.
class ElementParts {
public:
  /// One part, in the order of the elements.
  explicit ElementParts(std::size_t elements = 0)
      : first_{0, (elements + elements_in_block - 1) / elements_in_block} {}
  /// As many parts as the mesh permits; a single one if it has few elements or they are not
  /// numbered along a direction.
  template <int Dim>
  static ElementParts of(const mesh::Mesh<Dim>& mesh);

  std::size_t parts() const { return first_.size() - 1; }

  /// Calls use(part, first block, end of its blocks) for all parts, divided among the team lent to
  /// the calling thread.
  template <class Use>
  void for_each(const Use& use) const {
    const auto use_part = [&](std::size_t part) { use(part, first_[part], first_[part + 1]); };
    for_each_part((parts() + 1) / 2, [&](std::size_t pair) { use_part(2 * pair); });
    for_each_part(parts() / 2, [&](std::size_t pair) { use_part(2 * pair + 1); });
  }

private:
  /// Whether no two parts of one colour, even or odd, have a node in common.
  template <int Dim>
  bool divide(const mesh::Mesh<Dim>& mesh) const;

  std::vector<std::size_t> first_;  ///< first block of each part, and the end of the last one
};

}  // namespace dccast::mechanics
