#pragma once

#include <span>
#include <vector>

namespace dccast::contact {

/// Signorini's conditions at the nodes of the bottom and of walls, enforced by a primal-dual active
/// set (Hintermueller, Ito, Kunisch 2002): gap >= 0, reaction >= 0, one of them zero.
///
/// A pair in the set is held at zero gap, and its reaction results from the solution; a pair
/// outside carries no force, and its gap results from the solution. The generalised Newton method
/// of the paper's section 4.3.1 with eps_c -> 0 is this iteration (Lemma 5).
class ActiveSet {
public:
  struct Tolerance {
    double gap;    ///< [m] penetration that counts as zero
    double force;  ///< [N/m] tensile force that counts as zero; scaled to the weight, not to
                   ///< thermal forces
  };

  ActiveSet() = default;
  /// @param carrying  number of pairs, from the first, of which at least one must be closed
  ActiveSet(std::vector<char> active, std::size_t carrying)
      : active_(std::move(active)), carrying_(carrying) {}
  explicit ActiveSet(std::vector<char> active) : active_(std::move(active)) {
    carrying_ = active_.size();
  }

  const std::vector<char>& active() const { return active_; }
  bool active(std::size_t pair) const { return active_[pair] != 0; }

  /// Opens or closes the pairs that violate their condition. The carrying pairs are never all
  /// opened: a slab without any support has no equilibrium.
  /// @param gap         (pair) [m]
  /// @param reaction    (pair) [N/m], meaningful for active pairs only
  /// @param one_by_one  change only the worst violator, so that two pairs cannot keep switching
  ///                    each other
  /// @return number of pairs that changed
  int update(std::span<const double> gap, std::span<const double> reaction,
             const Tolerance& tolerance, bool one_by_one);

private:
  std::vector<char> active_;
  std::size_t carrying_ = 0;
};

/// Largest violation of gap >= 0 [m], reaction >= 0 [N/m] and of the complementarity of the two
/// [1], relative to the scales of length [m] and force [N/m].
double complementarity_error(std::span<const double> gap, std::span<const double> reaction,
                             double length_scale, double force_scale);

}  // namespace dccast::contact
