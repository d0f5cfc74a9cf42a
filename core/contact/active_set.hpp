#pragma once

#include <span>
#include <vector>

namespace dccast::contact {

/// Signorini's conditions at the nodes of the bottom and of walls, held by a primal-dual active set
/// (Hintermueller, Ito, Kunisch 2002): gap >= 0, reaction >= 0, one of them zero.
///
/// A pair in the set is held at zero gap and its reaction is an outcome; a pair outside carries no
/// force and its gap is an outcome. The generalised Newton method of the paper's section 4.3.1 with
/// eps_c -> 0 is this iteration (Lemma 5).
class ActiveSet {
public:
  struct Tolerance {
    double gap;    ///< [m] penetration that counts as zero
    double force;  ///< [N/m] pull that counts as zero; scaled to the weight, not to thermal forces
  };

  ActiveSet() = default;
  /// @param carrying  the first so many pairs are never all open
  ActiveSet(std::vector<char> active, std::size_t carrying)
      : active_(std::move(active)), carrying_(carrying) {}
  explicit ActiveSet(std::vector<char> active) : active_(std::move(active)) {
    carrying_ = active_.size();
  }

  const std::vector<char>& active() const { return active_; }
  bool active(std::size_t pair) const { return active_[pair] != 0; }

  /// Moves pairs that violate their condition across. After many changes, only the worst one, so
  /// that two pairs cannot send each other back and forth. Those that carry are never all opened: a
  /// slab without any support has no equilibrium.
  /// @param gap       of every pair [m]
  /// @param reaction  of every pair, meaningful where active [N/m]
  /// @param one_by_one  move only the worst violator
  /// @return number of pairs that changed
  int update(std::span<const double> gap, std::span<const double> reaction,
             const Tolerance& tolerance, bool one_by_one);

private:
  std::vector<char> active_;
  std::size_t carrying_ = 0;
};

/// Largest violation of gap >= 0 [m], reaction >= 0 [N/m] and their product, relative to the scales
/// given [m], [N/m]; a number [1].
double complementarity_error(std::span<const double> gap, std::span<const double> reaction,
                             double length_scale, double force_scale);

}  // namespace dccast::contact
