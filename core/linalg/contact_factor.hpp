#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// Two factors that follow a change of the held contact unknowns without starting over, beside
/// which Condensation is measured (docs/contact-factorisation.md). Both take the matrix K with
/// nothing held and solve K x = b on the free unknowns, zero on the held ones.

/// Contact unknowns ordered last, paper section 4.3.1: the rest is eliminated once, and a change
/// re-factorises only what belongs to the contact unknowns, a dense matrix of their number.
class TrailingFactor {
public:
  /// @param last  the unknowns that may change between held and free
  TrailingFactor(const SparsityPattern& pattern, std::vector<int> last);
  ~TrailingFactor();

  /// @param held  (unknown); those not in `last` stay as they are here
  /// @return false when the matrix of the free unknowns is not positive definite
  bool factorize(std::span<const double> values, std::span<const char> held);
  bool change(std::span<const char> held);
  void solve(std::span<const double> b, std::span<double> x);

private:
  struct Storage;
  std::unique_ptr<Storage> storage_;
};

/// Rows deleted from and added to an L D L' factor (Davis and Hager), which must be simplicial: the
/// first change converts a supernodal one.
class RowFactor {
public:
  explicit RowFactor(const SparsityPattern& pattern);
  ~RowFactor();

  /// @param values  must stay as they are until the next factorize()
  bool factorize(std::span<const double> values, std::span<const char> held);
  bool change(std::span<const char> held);
  void solve(std::span<const double> b, std::span<double> x);

private:
  struct Storage;
  std::unique_ptr<Storage> storage_;
};

}  // namespace dccast::linalg
