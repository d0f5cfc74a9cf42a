#pragma once

#include <cstddef>

namespace dccast::linalg {

/// Rows and columns of a tile.
inline constexpr int tile_size = 8;

/// A dense block of the factor by columns: entry (i, k) stands at tile_size * k + i.
struct alignas(64) Tile {
  double entry[tile_size * tile_size];
};

/// Part of a vector that belongs to a row of tiles.
struct alignas(64) TileRow {
  double entry[tile_size];
};

/// A lower triangular matrix in tiles between a monotone envelope and the diagonal: row I of tiles
/// holds columns first[I] to I, one after another from tile start[I] on.
struct TileBand {
  Tile* tile = nullptr;
  const std::size_t* start = nullptr;
  const int* first = nullptr;  ///< (row) never decreasing
  const int* last = nullptr;   ///< (column) last row of tiles that reaches it
  TileRow* inverse = nullptr;  ///< (row) reciprocals of the diagonal of the factor
  int rows = 0;
  /// Where a solve streams the factor from memory, row by row both ways: room for the sums of so
  /// many columns as a row reaches, zero before and after. Null where the factor is in the cache.
  Tile* sums = nullptr;
  int sum_columns = 0;

  Tile* at(int row, int column) const { return tile + start[row] + (column - first[row]); }
};

/// The numerical work of BandCholesky, compiled for several instruction sets. For the sources of
/// this room only.
struct TileKernels {
  const char* name;
  /// Work per unknown below which a band factorisation beats CHOLMOD's: the mean square of the
  /// height of its columns [1]. Measured in docs/factorisation.md.
  double flops_per_unknown;
  /// What a factorisation reaches [1/s]. Measured there too.
  double flops_per_second;
  /// Replaces the matrix by its Cholesky factor.
  /// @param from  first row of tiles to compute; those before it hold the factor already
  /// @return false when a pivot is not a positive number
  bool (*factorize)(const TileBand& band, int from);
  /// x <- (L L')^-1 x
  void (*solve)(const TileBand& band, TileRow* x);
};

/// Those of the instruction set in use, see instructions().
const TileKernels& best_tile_kernels();

/// All that this processor can run, plain C++ first.
struct TileKernelList {
  const TileKernels* kernel[3];
  int count;
};
TileKernelList runnable_tile_kernels();

}  // namespace dccast::linalg
