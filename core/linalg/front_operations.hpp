#pragma once

#include "core/linalg/tile_operations.hpp"

/// The kernels of a front of a dissection. For tile_kernels.cpp only.
namespace dccast::linalg::tiles {

/// Rows that are processed together because they do not depend on each other.
inline constexpr int rows_together = 4;

/// Columns of the factor in some consecutive rows, given all rows before.
template <int Lanes>
DCCAST_INLINE bool eliminate_rows(const Front& front, int first, int end) {
  const int columns = end < front.pivots ? end : front.pivots;
  for (int j = 0; j < columns; ++j) {
    const Tile* const pivot_row = front.row(j);
    for (int i = first > j ? first : j; i < end; ++i) {
      Tile* const row = front.row(i);
      subtract_products<Lanes>(row, pivot_row, j, row[j]);
      if (i == j) {
        if (!factorize_tile<Lanes>(row[j], front.inverse[j])) return false;
      } else {
        substitute<Lanes>(pivot_row[j], front.inverse[j], row[j]);
      }
    }
  }
  return true;
}

/// Contribution of the pivots to some consecutive rows of the boundary.
template <int Lanes>
DCCAST_INLINE void update_rows(const Front& front, int first, int end) {
  for (int j = 0; j < end; ++j) {
    const Tile* const other = front.row(front.pivots + j);
    for (int i = first > j ? first : j; i < end; ++i) {
      subtract_products<Lanes>(front.row(front.pivots + i), other, front.pivots,
                               front.update_row(i)[j]);
    }
  }
}

template <int Lanes>
DCCAST_INLINE bool factorize_front(const Front& front) {
  const auto end_of = [](int first, int end) {
    return first + rows_together < end ? first + rows_together : end;
  };
  for (int i = 0; i < front.pivots; i += rows_together) {
    if (!eliminate_rows<Lanes>(front, i, end_of(i, front.pivots))) return false;
  }
  for (int i = 0; i < front.boundary; i += rows_together) {
    const int end = end_of(i, front.boundary);
    eliminate_rows<Lanes>(front, front.pivots + i, front.pivots + end);
    update_rows<Lanes>(front, i, end);
  }
  return true;
}

/// Sum of the products of the first tiles of a row with x.
template <int Lanes>
DCCAST_INLINE void row_times(const Tile* row, const TileRow* x, int count, TileRow& sum) {
  constexpr int parts = tile_size / Lanes, chains = Lanes / 2;
  typename Register<Lanes>::type sums[chains][parts] = {};
  add_products<Lanes>(row, x, count, sums);
  for (int p = 0; p < parts; ++p) {
    for (int c = 1; c < chains; ++c) sums[0][p] += sums[c][p];
    rows_at<Lanes>(sum.entry + Lanes * p) = sums[0][p];
  }
}

template <int Lanes>
DCCAST_INLINE void forward_front(const Front& front, TileRow* x, TileRow* rest) {
  TileRow sum;
  for (int i = 0; i < front.pivots; ++i) {
    const Tile* const row = front.row(i);
    row_times<Lanes>(row, x, i, sum);
    for (int k = 0; k < tile_size; ++k) x[i].entry[k] -= sum.entry[k];
    substitute_forward(row[i], front.inverse[i], x[i]);
  }
  for (int i = 0; i < front.boundary; ++i)
    row_times<Lanes>(front.row(front.pivots + i), x, front.pivots, rest[i]);
}

/// What the boundary gives to the pivots, from its last row to its first.
template <int Lanes>
DCCAST_INLINE void add_boundary(const Front& front, const TileRow* rest, Tile* sums) {
  static_assert(rows_together == 4);
  int i = front.boundary;
  for (; i % rows_together != 0; --i) {
    const Tile* const one[] = {front.row(front.pivots + i - 1)};
    add_transposed_products<Lanes>(one, front.pivots, rest + i - 1, sums);
  }
  for (; i > 0; i -= rows_together) {
    const int first = front.pivots + i - rows_together;
    const Tile* const four[] = {front.row(first), front.row(first + 1), front.row(first + 2),
                                front.row(first + 3)};
    add_transposed_products<Lanes>(four, front.pivots, rest + i - rows_together, sums);
  }
}

template <int Lanes>
DCCAST_INLINE void backward_front(const Front& front, TileRow* x, const TileRow* rest, Tile* sums) {
  add_boundary<Lanes>(front, rest, sums);
  for (int j = front.pivots - 1; j >= 0; --j) {
    const Tile* const row[] = {front.row(j)};
    subtract_sums(sums[j], x[j]);
    sums[j] = Tile{};
    substitute_back(row[0][j], front.inverse[j], x[j]);
    add_transposed_products<Lanes>(row, j, x + j, sums);
  }
}

}  // namespace dccast::linalg::tiles
