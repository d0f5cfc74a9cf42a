#pragma once

#include <vector>

#include "core/base/symmetric_tensor.hpp"

namespace dccast::mechanics {

/// Everything the mechanics of a slab carries from one step to the next; what a checkpoint keeps.
template <int Dim>
struct SlabState {
  using Tensor = SymmetricTensor<Dim>;

  bool started = false;              ///< before, the slab has no displacement and no history
  std::vector<double> displacement;  ///< (node, Dim) [m]
  std::vector<char> released;        ///< (node) released by the mould for good
  std::vector<char> solid;           ///< (element) carries stress
  /// (element, point) strain that carries no stress: reference at solidification, less its
  /// thermal stretch, and viscoplastic strain since then.
  std::vector<Tensor> inelastic;
  std::vector<Tensor> viscoplastic;  ///< (element, point) the viscoplastic part alone
  std::vector<Tensor> deviator;      ///< (element, point) stress deviator [Pa]
  std::vector<double> pressure;      ///< (element, point) mean normal stress [Pa]
  std::vector<char> contact;         ///< (bottom node) closed
  std::vector<double> contact_multiplier;  ///< (bottom node) [Pa], of sbm only
  std::vector<double> reaction;  ///< (bottom node) of the last step [N/m], of a billet [N/rad]
};

}  // namespace dccast::mechanics
