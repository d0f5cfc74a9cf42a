#pragma once

#include <cstddef>

#include "core/base/team.hpp"

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

/// The rows or columns of a band that one member of a team computes: every so many-th. A member
/// computes them as one alone would, number by number, and waits where it needs those of others.
struct BandShare {
  int member = 0, members = 1;
  /// Rows that are done: of a factorisation and of the forward half of a solve the last one, of its
  /// backward half how many from the end. Null for one that is alone.
  Progress *factorized = nullptr, *forward = nullptr, *backward = nullptr;

  /// Its first row from this one on, and its last one up to this one; the next is `members` away.
  int first_from(int row) const { return row + (member + members - row % members) % members; }
  int last_up_to(int row) const { return row - (row + members - member) % members; }
  bool owns(int row) const { return row % members == member; }
};

/// A front of a dissection: the columns of its pivots in the factor, and what their elimination
/// leaves of its boundary. Row I of tiles of the panel holds columns 0 to min(I, pivots - 1), one
/// row after another.
struct Front {
  Tile* panel = nullptr;
  Tile* update = nullptr;      ///< lower triangle of the boundary, row by row of tiles
  TileRow* inverse = nullptr;  ///< (row of pivots) reciprocals of the diagonal of the factor
  int pivots = 0;              ///< rows of tiles
  int boundary = 0;            ///< rows of tiles below them

  /// First tile of a row of the panel.
  static std::size_t row_start(int row, int pivots) {
    const std::size_t i = std::size_t(row), k = std::size_t(pivots);
    return i < k ? i * (i + 1) / 2 : k * (k + 1) / 2 + (i - k) * k;
  }
  Tile* row(int i) const { return panel + row_start(i, pivots); }
  Tile* update_row(int i) const { return update + std::size_t(i) * std::size_t(i + 1) / 2; }
};

/// The numerical work of BandCholesky and DissectionCholesky, compiled for several instruction
/// sets. For the sources of this room only.
struct TileKernels {
  const char* name;
  /// Work per unknown below which a band factorisation beats CHOLMOD's: the mean square of the
  /// height of its columns [1]. Measured in docs/factorisation.md.
  double flops_per_unknown;
  /// What a factorisation reaches [1/s]. Measured there too.
  double flops_per_second;
  /// Replaces the matrix by its Cholesky factor.
  /// @param from   first row of tiles to compute; those before it hold the factor already
  /// @param share  its rows
  /// @return false when a pivot is not a positive number, to one member at least
  bool (*factorize)(const TileBand& band, int from, const BandShare& share);
  /// x <- (L L')^-1 x. Several members only where the band has room for sums.
  /// @param share  its rows on the way forward, its columns on the way back
  void (*solve)(const TileBand& band, TileRow* x, const BandShare& share);
  /// Replaces the panel of a front by its columns of the factor and subtracts from the update what
  /// they give to it. @return false when a pivot is not a positive number
  bool (*factorize_front)(const Front& front);
  /// x <- L^-1 x of the pivots. @param rest  gets what they give to the boundary
  void (*forward_front)(const Front& front, TileRow* x, TileRow* rest);
  /// x <- (L')^-1 x of the pivots. @param rest  the solution on the boundary
  /// @param sums  room for as many tiles as there are rows of pivots, zero before and after
  void (*backward_front)(const Front& front, TileRow* x, const TileRow* rest, Tile* sums);
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
