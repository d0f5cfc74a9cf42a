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

}  // namespace dccast::linalg::tiles
