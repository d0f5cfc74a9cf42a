#pragma once

#include <vector>

#include "core/base/tensors.hpp"

namespace dccast::mechanics {

/// The complete mechanical state of a slab between steps, as stored in a checkpoint.
template <int Dim>
struct SlabState {
  using Tensor = SymmetricTensor<Dim>;

  bool started = false;              ///< false: the slab has no displacement and no history yet
  std::vector<double> displacement;  ///< (node, Dim) [m]
  std::vector<char> released;        ///< (node) permanently released by the mould
  std::vector<char> solid;           ///< (element) carries stress
  /// (element, point) stress-free strain [1]: reference strain at solidification minus its thermal
  /// stretch, plus the viscoplastic strain since then.
  std::vector<Tensor> inelastic;
  std::vector<Tensor> viscoplastic;        ///< (element, point) viscoplastic part of it [1]
  std::vector<Tensor> deviator;            ///< (element, point) stress deviator [Pa]
  std::vector<double> pressure;            ///< (element, point) mean normal stress [Pa]
  std::vector<char> contact;               ///< (bottom node) closed
  std::vector<double> contact_multiplier;  ///< (bottom node) [Pa], for sbm only
  std::vector<double> reaction;            ///< (bottom node) in the last step [N/m], billet [N/rad]
};

}  // namespace dccast::mechanics
