#pragma once

#include <limits>

#include "core/linalg/tile_kernels.hpp"

/// Compiled into the kernel that calls it, for its instruction set.
#define DCCAST_INLINE [[gnu::always_inline]] inline

/// Building blocks of the kernels on tiles. For the sources of this room only.
/// @tparam Lanes  numbers per register of the instruction set
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
namespace dccast::linalg::tiles {

/// As many rows of a column as a register of the instruction set holds.
template <int Lanes>
struct Register {
  typedef double type __attribute__((vector_size(8 * Lanes), may_alias));
};

/// Rows of a column that fill one register.
template <int Lanes>
DCCAST_INLINE auto& rows_at(double* column) {
  return *reinterpret_cast<typename Register<Lanes>::type*>(column);
}
template <int Lanes>
DCCAST_INLINE const auto& rows_at(const double* column) {
  return *reinterpret_cast<const typename Register<Lanes>::type*>(column);
}

/// result -= sum over `count` tiles of left right'.
template <int Lanes>
DCCAST_INLINE void subtract_products(const Tile* left, const Tile* right, int count, Tile& result) {
  constexpr int parts = tile_size / Lanes, pass = tile_size / parts;  // eight sums in registers
  for (int j0 = 0; j0 < tile_size; j0 += pass) {
    typename Register<Lanes>::type sum[pass][parts];
    double* to = result.entry + tile_size * j0;
    for (int j = 0; j < pass; ++j) {
      for (int p = 0; p < parts; ++p) sum[j][p] = rows_at<Lanes>(to + tile_size * j + Lanes * p);
    }

    const double* a = left->entry;
    const double* b = right->entry + j0;
    for (int k = 0; k < tile_size * count; ++k, a += tile_size, b += tile_size) {
      for (int j = 0; j < pass; ++j) {
        for (int p = 0; p < parts; ++p) sum[j][p] -= rows_at<Lanes>(a + Lanes * p) * b[j];
      }
    }

    for (int j = 0; j < pass; ++j) {
      for (int p = 0; p < parts; ++p) rows_at<Lanes>(to + tile_size * j + Lanes * p) = sum[j][p];
    }
  }
}

/// tile <- tile (factor')^-1, column by column from the left.
template <int Lanes>
DCCAST_INLINE void substitute(const Tile& factor, const TileRow& inverse, Tile& tile) {
  for (int p = 0; p < tile_size; p += Lanes) {
    typename Register<Lanes>::type column[tile_size];
    for (int k = 0; k < tile_size; ++k) column[k] = rows_at<Lanes>(tile.entry + tile_size * k + p);

    // A column is final once divided by its pivot; it is then removed from the columns after it.
    for (int k = 0; k < tile_size; ++k) {
      column[k] *= inverse.entry[k];
      for (int j = k + 1; j < tile_size; ++j) {
        column[j] -= column[k] * factor.entry[tile_size * k + j];
      }
    }

    for (int k = 0; k < tile_size; ++k) rows_at<Lanes>(tile.entry + tile_size * k + p) = column[k];
  }
}

/// Cholesky factor of a diagonal tile, zero above the diagonal. Returns false if a pivot is not
/// positive.
template <int Lanes>
DCCAST_INLINE bool factorize_tile(Tile& tile, TileRow& inverse) {
  for (int k = 0; k < tile_size; ++k) {
    double* column = tile.entry + tile_size * k;
    const double pivot = column[k];
    if (!(pivot > 0.0 && pivot < std::numeric_limits<double>::infinity())) return false;

    const double root = __builtin_sqrt(pivot);
    inverse.entry[k] = root * (1.0 / pivot);  // root and reciprocal are independent operations

    for (int i = 0; i < k; ++i) column[i] = 0.0;
    for (int p = 0; p < tile_size; p += Lanes) rows_at<Lanes>(column + p) *= inverse.entry[k];

    for (int j = k + 1; j < tile_size; ++j) {
      for (int p = 0; p < tile_size; p += Lanes) {
        rows_at<Lanes>(tile.entry + tile_size * j + p) -= rows_at<Lanes>(column + p) * column[j];
      }
    }
  }
  return true;
}

/// Adds the products of consecutive tiles of a row with x to independent sums.
template <int Lanes, int Chains>
DCCAST_INLINE void add_products(const Tile* tile, const TileRow* x, int count,
                                typename Register<Lanes>::type (&sum)[Chains][tile_size / Lanes]) {
  for (int c = 0; c < count; ++c) {
    for (int k = 0; k < tile_size; ++k) {
      for (int p = 0; p < tile_size / Lanes; ++p) {
        sum[k % Chains][p] +=
            rows_at<Lanes>(tile[c].entry + tile_size * k + Lanes * p) * x[c].entry[k];
      }
    }
  }
}

/// Forward substitution with a diagonal tile.
DCCAST_INLINE void substitute_forward(const Tile& factor, const TileRow& inverse, TileRow& x) {
  for (int k = 0; k < tile_size; ++k) {
    const double found = x.entry[k] * inverse.entry[k];
    for (int r = k; r < tile_size; ++r) x.entry[r] -= factor.entry[tile_size * k + r] * found;
    x.entry[k] = found;
  }
}

/// Backward substitution with a diagonal tile.
DCCAST_INLINE void substitute_back(const Tile& factor, const TileRow& inverse, TileRow& x) {
  for (int k = tile_size - 1; k >= 0; --k) {
    x.entry[k] *= inverse.entry[k];
    for (int i = 0; i < k; ++i) x.entry[i] -= factor.entry[tile_size * i + k] * x.entry[k];
  }
}

/// x <- x - sum of the columns of a tile of products.
DCCAST_INLINE void subtract_sums(const Tile& products, TileRow& x) {
  for (int k = 0; k < tile_size; ++k) {
    for (int p = 0; p < tile_size; ++p) x.entry[k] -= products.entry[tile_size * k + p];
  }
}

/// Adds the products of the transposed consecutive tiles of some rows with x to the sums, the last
/// row first; the columns of the sums still have to be added up. Processing several rows at once
/// reads and writes the sums only once.
/// @param x  one for each row
template <int Lanes, int Rows>
DCCAST_INLINE void add_transposed_products(const Tile* const (&row)[Rows], int count,
                                           const TileRow* x, Tile* sums) {
  constexpr int parts = tile_size / Lanes;
  typename Register<Lanes>::type found[Rows][parts];
  for (int r = 0; r < Rows; ++r) {
    for (int p = 0; p < parts; ++p) found[r][p] = rows_at<Lanes>(x[r].entry + Lanes * p);
  }

  // Sums stay in registers over all rows of the group.
  for (int c = 0; c < count; ++c) {
    for (int k = 0; k < tile_size; ++k) {
      for (int p = 0; p < parts; ++p) {
        const int entry = tile_size * k + Lanes * p;
        auto sum = rows_at<Lanes>(sums[c].entry + entry);
        for (int r = Rows; r-- > 0;) sum += rows_at<Lanes>(row[r][c].entry + entry) * found[r][p];
        rows_at<Lanes>(sums[c].entry + entry) = sum;
      }
    }
  }
}

// The kernels of a front of a dissection. For tile_kernels.cpp only.

/// Rows that are processed together because they do not depend on each other.
inline constexpr int rows_together = 4;

/// Computes the columns of the factor in some consecutive rows, given all rows before.
/// @return false: the matrix is not positive definite
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

/// @see TileKernels::factorize_front
template <int Lanes>
DCCAST_INLINE bool factorize_front(const Front& front) {
  const auto group_end = [](int first, int end) {
    return first + rows_together < end ? first + rows_together : end;
  };

  // Pivots first: all rows of the boundary need their factor.
  for (int i = 0; i < front.pivots; i += rows_together) {
    if (!eliminate_rows<Lanes>(front, i, group_end(i, front.pivots))) return false;
  }

  for (int i = 0; i < front.boundary; i += rows_together) {
    const int end = group_end(i, front.boundary);
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

/// @see TileKernels::forward_front
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

/// Adds the products of the boundary to the sums of the pivots, from its last row to its first.
template <int Lanes>
DCCAST_INLINE void add_boundary(const Front& front, const TileRow* rest, Tile* sums) {
  static_assert(rows_together == 4);
  int i = front.boundary;
  for (; i % rows_together != 0; --i) {
    const Tile* const row[] = {front.row(front.pivots + i - 1)};
    add_transposed_products<Lanes>(row, front.pivots, rest + i - 1, sums);
  }

  // The other rows in groups, each of which reads and writes the sums once.
  for (; i > 0; i -= rows_together) {
    const int first = front.pivots + i - rows_together;
    const Tile* const rows[] = {front.row(first), front.row(first + 1), front.row(first + 2),
                                front.row(first + 3)};
    add_transposed_products<Lanes>(rows, front.pivots, rest + i - rows_together, sums);
  }
}

/// @see TileKernels::backward_front
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
