#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"
#include "core/linalg/tile_kernels.hpp"

namespace dccast::linalg {

/// Structure and size of a band factor, known before any number is computed.
struct BandShape {
  std::vector<int> first;          ///< (row of tiles) first column of tiles, never decreasing
  std::vector<int> last;           ///< (column of tiles) last row that has an entry in it
  std::vector<std::size_t> start;  ///< (row of tiles + 1) index of its first tile
  double flops = 0.0;              ///< [1] multiplications and additions of a factorisation

  /// @param place  (unknown) its position in the order of elimination
  BandShape(const SparsityPattern& pattern, std::span<const int> place);
  /// An empty shape.
  BandShape() = default;
  /// Number of rows of tiles.
  int rows() const { return static_cast<int>(first.size()); }
};

/// Cholesky factorisation of a symmetric positive definite matrix with entries near the diagonal,
/// in dense tiles inside the envelope of the rows.
///
/// Made for slab meshes, whose nodes are numbered row by row: there is no fill outside the band,
/// and all work is in dense products of 8 x 8 tiles. The kernels are chosen at run time for the
/// processor, so the last bits of a solution may differ between processors with different
/// instruction sets; on one processor they are always the same.
///
/// factorize() and solve() divide large work among the team lent to the calling thread
/// (core/base/team.hpp); the bits do not depend on its size.
///
/// factorize() and solve() do not allocate memory. A factorisation starts at the first row whose
/// entries have changed since the previous one; the factor is bit-identical to one computed from
/// the first row.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
class BandCholesky {
public:
  explicit BandCholesky(const TileKernels& kernels = best_tile_kernels()) : kernels_(&kernels) {}

  /// Symbolic analysis. @param place  (unknown) its position in the order of elimination
  void analyze(const SparsityPattern& pattern, std::span<const int> place);
  /// The same with the shape of this order, where the caller has already computed it.
  void analyze(const SparsityPattern& pattern, std::span<const int> place, BandShape shape);

  /// @param values  (entry of the pattern)
  /// @return false if the matrix is not positive definite; the factor is then unusable
  [[nodiscard]] bool factorize(std::span<const double> values);
  /// Solves with the last factor. @param x  may be the same storage as `b`
  void solve(std::span<const double> b, std::span<double> x);

  /// Share of the rows that a factorisation repeats if only entries of this unknown change [1].
  double share_to_repeat(int unknown) const;

  /// Structure of the present factor, for the choice of a method and for tests.
  const BandShape& shape() const { return shape_; }
  /// Numbers in the factor [1].
  double factor_entries() const { return 64.0 * static_cast<double>(tiles()); }
  /// Memory used by the factor and its structure [byte].
  std::size_t memory_bytes() const;
  /// Share of the rows that the last factorisation computed [1].
  double share_computed() const { return share_computed_; }

private:
  /// Finds the places of the entries of a matrix in the tiles of `shape_`.
  void sort_entries(const SparsityPattern& pattern);
  /// Tiles of the factor.
  std::size_t tiles() const { return shape_.start.empty() ? 0 : shape_.start.back(); }
  /// First row of tiles whose entries differ in any bit from those of the present factor.
  int first_changed_row(std::span<const double> values) const;
  /// Whether the entries of a row of tiles differ in any bit from those of the present factor.
  bool has_changed(std::size_t row, std::span<const double> values) const;
  /// Copies the entries from a row of tiles on; the diagonal past the last unknown is one.
  void copy_matrix(std::span<const double> values, int from);
  /// Copies the entries of a row of tiles, and zeroes the rest of it.
  void copy_row(std::size_t row, std::span<const double> values);
  /// Whether a solution has to read the factor from memory: it exceeds cache_bytes.
  bool streams() const;
  /// Whether a factorisation is large enough to pay for the synchronisation of a team.
  bool is_worth_sharing() const;
  /// Factorises from a row of tiles on. @return false if the matrix is not positive definite
  [[nodiscard]] bool factorize_from(int row);
  /// The view of the factor that the kernels take.
  TileBand band();

  const TileKernels* kernels_;
  BandShape shape_;
  std::vector<int> place_;  ///< (unknown) position in the order of elimination
  // The entries of the matrix, sorted by rows of tiles.
  std::vector<std::size_t> row_start_;  ///< (row of tiles + 1) its first entry
  std::vector<int> source_;             ///< (entry) its index in the pattern
  std::vector<int> target_;             ///< (entry) its index in the row of tiles
  std::vector<double> values_;          ///< (entry) matrix of the present factor
  bool whole_ = false;                  ///< the factor is complete and belongs to `values_`
  TileStorage tile_;
  /// (row of tiles) reciprocals of the diagonal of the factor.
  std::vector<TileRow> inverse_;
  /// (row of tiles) right-hand side, then solution.
  std::vector<TileRow> right_;
  std::vector<Tile> sums_;  ///< @see TileBand
  double share_computed_ = 1.0;
};

}  // namespace dccast::linalg
