#pragma once

#include <cstddef>
#include <memory>

#include "core/base/team.hpp"

namespace dccast::linalg {

/// Rows and columns of a tile.
inline constexpr int tile_size = 8;

/// A dense block of the factor by columns: entry (i, k) has index tile_size * k + i.
struct alignas(64) Tile {
  double entry[tile_size * tile_size];
};

/// Part of a vector that belongs to a row of tiles.
struct alignas(64) TileRow {
  double entry[tile_size];
};

/// A lower triangular matrix in tiles between a monotone envelope and the diagonal: row I of tiles
/// holds columns first[I] to I, stored consecutively from tile start[I] on.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
struct TileBand {
  Tile* tile = nullptr;
  const std::size_t* start = nullptr;
  const int* first = nullptr;  ///< (row) never decreasing
  const int* last = nullptr;   ///< (column) last row of tiles that has an entry in it
  TileRow* inverse = nullptr;  ///< (row) reciprocals of the diagonal of the factor
  int rows = 0;
  /// Used if a solve streams the factor from memory, row by row in both directions: workspace for
  /// sums of as many columns as a row has, zero before and after. Null if the factor fits in the
  /// cache.
  Tile* sums = nullptr;
  int sum_columns = 0;

  /// Tile of a row and a column inside the envelope.
  Tile* at(int row, int column) const { return tile + start[row] + (column - first[row]); }
};

/// The rows or columns of a band that one member of a team computes, in round-robin order. A member
/// does the same arithmetic as a single thread, and waits when it needs the rows of others.
struct BandShare {
  /// Number of this member, and size of the team.
  int member = 0, members = 1;
  /// Completed rows: the last one for a factorisation and for the forward substitution, the number
  /// from the end for the backward substitution. Null for a single thread.
  Progress *factorized = nullptr, *forward = nullptr, *backward = nullptr;

  /// Its first row from this one on, and its last row up to this one; consecutive rows are
  /// `members` apart.
  int first_from(int row) const { return row + (member + members - row % members) % members; }
  int last_up_to(int row) const { return row - (row + members - member) % members; }
  /// Whether this member computes a row.
  bool owns(int row) const { return row % members == member; }
};

/// The numerical work of BandCholesky, compiled for several instruction sets. For the sources of
/// this room only.
struct TileKernels {
  /// Name of the instruction set, as in DCCAST_INSTRUCTIONS.
  const char* name;
  /// Work per unknown below which a band factorisation is faster than CHOLMOD's: the mean square of
  /// the height of its columns [1]. Measured, see docs/developers/factorisation.md.
  double flops_per_unknown;
  /// Speed of a factorisation in floating-point operations per second [1/s]. Measured, see
  /// docs/developers/factorisation.md.
  double flops_per_second;
  /// Replaces the matrix by its Cholesky factor.
  /// @param from   first row of tiles to compute; those before it already hold the factor
  /// @param share  rows of this member
  /// @return false if a pivot is not positive; at least one member of the team gets it
  bool (*factorize)(const TileBand& band, int from, const BandShare& share);
  /// x <- (L L')^-1 x. Several members only if the band has workspace for sums.
  /// @param share  rows of this member in the forward, columns in the backward substitution
  void (*solve)(const TileBand& band, TileRow* x, const BandShare& share);
};

/// The kernels for the instruction set in use, see instructions().
const TileKernels& best_tile_kernels();

/// All kernels that this processor can run, plain C++ first.
struct TileKernelList {
  const TileKernels* kernel[3];
  int count;
};
/// For tests: every kernel must give the same solution to round-off.
TileKernelList runnable_tile_kernels();

/// A factor larger than this is no longer in the cache when a solve needs it [byte]. Measured, see
/// docs/developers/factorisation.md.
inline constexpr std::size_t cache_bytes = std::size_t(8) << 20;

/// Uninitialised storage for the tiles of a factor, in huge pages if it is large: a solve reads all
/// of it.
class TileStorage {
public:
  /// Reserves memory for a number of tiles; the content is lost if the storage has to grow. It
  /// grows with a reserve for a few rows of cells: touching new memory costs more than a
  /// factorisation.
  /// @throws std::bad_alloc
  void reserve(std::size_t tiles);

  /// The tiles; valid until the next reserve().
  Tile* get() const { return tile_.get(); }
  Tile& operator[](std::size_t i) const { return tile_[i]; }
  /// Memory that is reserved [byte].
  std::size_t bytes() const { return capacity_ * sizeof(Tile); }

private:
  /// Frees what reserve() has obtained.
  struct Free {
    void operator()(Tile* tiles) const;
  };
  std::unique_ptr<Tile[], Free> tile_;
  std::size_t capacity_ = 0;
};

}  // namespace dccast::linalg
