#include "core/linalg/tile_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/instructions.hpp"

#define DCCAST_INLINE [[gnu::always_inline]] inline

namespace dccast::linalg {

namespace {

/// As many rows of a column as a register of the instruction set holds.
template <int Lanes>
struct Register {
  typedef double type __attribute__((vector_size(8 * Lanes), may_alias));
};

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
  constexpr int parts = tile_size / Lanes, pass = tile_size / parts;  // so that eight sums are held
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

/// tile <- tile (factor')^-1, columns from the left.
template <int Lanes>
DCCAST_INLINE void substitute(const Tile& factor, const TileRow& inverse, Tile& tile) {
  for (int p = 0; p < tile_size; p += Lanes) {
    typename Register<Lanes>::type column[tile_size];
    for (int k = 0; k < tile_size; ++k) column[k] = rows_at<Lanes>(tile.entry + tile_size * k + p);
    for (int k = 0; k < tile_size; ++k) {
      column[k] *= inverse.entry[k];
      for (int j = k + 1; j < tile_size; ++j) {
        column[j] -= column[k] * factor.entry[tile_size * k + j];
      }
    }
    for (int k = 0; k < tile_size; ++k) rows_at<Lanes>(tile.entry + tile_size * k + p) = column[k];
  }
}

/// Cholesky factor of a tile of the diagonal, zero above it. false: a pivot is not positive.
template <int Lanes>
DCCAST_INLINE bool factorize_tile(Tile& tile, TileRow& inverse) {
  for (int k = 0; k < tile_size; ++k) {
    double* column = tile.entry + tile_size * k;
    const double pivot = column[k];
    if (!(pivot > 0.0 && pivot < std::numeric_limits<double>::infinity())) return false;
    const double root = __builtin_sqrt(pivot);
    inverse.entry[k] = root * (1.0 / pivot);  // root and reciprocal do not wait for each other
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

/// What a factorisation of several members has reached when a pivot was no positive number.
constexpr int no_factor = std::numeric_limits<int>::max();

/// The tile of the diagonal, given all other tiles of its row; others may then go on with its
/// column.
template <int Lanes>
DCCAST_INLINE bool finish_row(const TileBand& band, int j, const BandShare& share) {
  const int first = band.first[j];
  Tile& tile = *band.at(j, j);
  subtract_products<Lanes>(band.at(j, first), band.at(j, first), j - first, tile);
  const bool positive = factorize_tile<Lanes>(tile, band.inverse[j]);
  if (share.factorized != nullptr) share.factorized->reach(positive ? j : no_factor);
  return positive;
}

/// Column by column of tiles, from the left: the rows of one column do not wait for each other.
/// The row below the diagonal comes first and is finished at once, so that the next column can
/// begin while this one goes on.
template <int Lanes>
DCCAST_INLINE bool factorize_band(const TileBand& band, int from, const BandShare& share) {
  for (int j = from < band.rows ? band.first[from] : band.rows; j < band.rows; ++j) {
    const bool begins = band.first[j] == j && j >= from;
    if (begins && share.owns(j) && !finish_row<Lanes>(band, j, share)) return false;
    if (share.factorized != nullptr && share.factorized->wait_for(j) == no_factor) return false;
    const int below = j + 1 < from ? from : j + 1;
    for (int i = share.first_from(below); i <= band.last[j]; i += share.members) {
      const int first = band.first[i];
      Tile& tile = *band.at(i, j);
      subtract_products<Lanes>(band.at(i, first), band.at(j, first), j - first, tile);
      substitute<Lanes>(*band.at(j, j), band.inverse[j], tile);
      if (i == j + 1 && !finish_row<Lanes>(band, i, share)) return false;
    }
  }
  return true;
}

/// Adds the products of consecutive tiles of a row with x to sums that do not wait for each other.
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

/// x <- L^-1 x in a row of tiles, given the rows before.
template <int Lanes>
DCCAST_INLINE void forward(const TileBand& band, int i, TileRow* x, const BandShare& share) {
  constexpr int parts = tile_size / Lanes, chains = Lanes / 2;
  typename Register<Lanes>::type sum[chains][parts] = {};
  const int first = band.first[i];
  // Its own row before this one, and with it all before that, are done.
  const int late = first > i - share.members + 1 ? first : i - share.members + 1;
  add_products<Lanes>(band.at(i, first), x + first, late - first, sum);
  if (share.forward != nullptr) share.forward->wait_for(i - 1);
  add_products<Lanes>(band.at(i, late), x + late, i - late, sum);
  for (int c = 0; c < chains; ++c) {
    for (int p = 0; p < parts; ++p) rows_at<Lanes>(x[i].entry + Lanes * p) -= sum[c][p];
  }
  const Tile& own = *band.at(i, i);
  for (int k = 0; k < tile_size; ++k) {
    const double found = x[i].entry[k] * band.inverse[i].entry[k];
    for (int r = k; r < tile_size; ++r) x[i].entry[r] -= own.entry[tile_size * k + r] * found;
    x[i].entry[k] = found;
  }
  if (share.forward != nullptr) share.forward->reach(i);
}

/// x <- (L')^-1 x with the tile of the diagonal.
DCCAST_INLINE void substitute_back(const TileBand& band, int j, TileRow* x) {
  const Tile& tile = *band.at(j, j);
  for (int k = tile_size - 1; k >= 0; --k) {
    x[j].entry[k] *= band.inverse[j].entry[k];
    for (int i = 0; i < k; ++i) x[j].entry[i] -= tile.entry[tile_size * i + k] * x[j].entry[k];
  }
}

/// x <- (L')^-1 x in a row of tiles, given the rows after.
template <int Lanes>
DCCAST_INLINE void backward(const TileBand& band, int j, TileRow* x) {
  constexpr int parts = tile_size / Lanes, pass = tile_size / parts;
  for (int k0 = 0; k0 < tile_size; k0 += pass) {
    typename Register<Lanes>::type sum[pass][parts] = {};
    for (int i = j + 1; i <= band.last[j]; ++i) {
      const double* column = band.at(i, j)->entry + tile_size * k0;
      for (int k = 0; k < pass; ++k) {
        for (int p = 0; p < parts; ++p) {
          sum[k][p] += rows_at<Lanes>(column + tile_size * k + Lanes * p) *
                       rows_at<Lanes>(x[i].entry + Lanes * p);
        }
      }
    }
    for (int k = 0; k < pass; ++k) {
      for (int p = 0; p < tile_size; ++p) x[j].entry[k0 + k] -= sum[k][p / Lanes][p % Lanes];
    }
  }
  substitute_back(band, j, x);
}

/// x <- (L')^-1 x in a row of tiles, given the sum of what the rows after give to its column.
DCCAST_INLINE void finish_column(const TileBand& band, int j, TileRow* x, const BandShare& share) {
  Tile& own = band.sums[j % band.sum_columns];
  for (int k = 0; k < tile_size; ++k) {
    for (int p = 0; p < tile_size; ++p) x[j].entry[k] -= own.entry[tile_size * k + p];
  }
  own = Tile{};
  substitute_back(band, j, x);
  if (share.backward != nullptr) share.backward->reach(band.rows - j);
}

/// x <- (L')^-1 x, row by row from the last one: each adds to the sums of the columns before what
/// it gives to them. All tiles are met from the last one down, which is as fast as memory streams;
/// by columns it is a third of that. The column before a row is finished first, so that the next
/// row can begin while this one goes on.
template <int Lanes>
DCCAST_INLINE void backward_streaming(const TileBand& band, TileRow* x, const BandShare& share) {
  constexpr int parts = tile_size / Lanes;
  for (int j = band.rows - 1; j >= 0; --j) {
    if (band.last[j] == j && share.owns(j)) finish_column(band, j, x, share);
    if (share.backward != nullptr) share.backward->wait_for(band.rows - j);
    typename Register<Lanes>::type found[parts];
    for (int p = 0; p < parts; ++p) found[p] = rows_at<Lanes>(x[j].entry + Lanes * p);
    for (int c = share.last_up_to(j - 1); c >= band.first[j]; c -= share.members) {
      const Tile* tile = band.at(j, c);
      double* sum = band.sums[c % band.sum_columns].entry;
      for (int k = tile_size - 1; k >= 0; --k) {
        for (int p = 0; p < parts; ++p) {
          const int at = tile_size * k + Lanes * p;
          rows_at<Lanes>(sum + at) += rows_at<Lanes>(tile->entry + at) * found[p];
        }
      }
      if (c == j - 1) finish_column(band, c, x, share);
    }
  }
}

template <int Lanes>
DCCAST_INLINE void solve_band(const TileBand& band, TileRow* x, const BandShare& share) {
  for (int i = share.first_from(0); i < band.rows; i += share.members) {
    forward<Lanes>(band, i, x, share);
  }
  if (band.sums == nullptr) {
    for (int j = band.rows - 1; j >= 0; --j) backward<Lanes>(band, j, x);
  } else {
    backward_streaming<Lanes>(band, x, share);
  }
}

bool factorize_plain(const TileBand& band, int from, const BandShare& share) {
  return factorize_band<2>(band, from, share);
}
void solve_plain(const TileBand& band, TileRow* x, const BandShare& share) {
  solve_band<2>(band, x, share);
}
constexpr TileKernels plain{"plain", 120.0 * 120.0, 16e9, factorize_plain, solve_plain};

#if defined(__x86_64__) && defined(__GNUC__)
#define DCCAST_AVX2 [[gnu::target("avx2,fma")]]
#define DCCAST_AVX512 [[gnu::target("avx512f,avx512vl,avx512dq,avx2,fma")]]

DCCAST_AVX2 bool factorize_avx2(const TileBand& band, int from, const BandShare& share) {
  return factorize_band<4>(band, from, share);
}
DCCAST_AVX2 void solve_avx2(const TileBand& band, TileRow* x, const BandShare& share) {
  solve_band<4>(band, x, share);
}
constexpr TileKernels avx2{"AVX2", 200.0 * 200.0, 38e9, factorize_avx2, solve_avx2};

DCCAST_AVX512 bool factorize_avx512(const TileBand& band, int from, const BandShare& share) {
  return factorize_band<8>(band, from, share);
}
DCCAST_AVX512 void solve_avx512(const TileBand& band, TileRow* x, const BandShare& share) {
  solve_band<8>(band, x, share);
}
constexpr TileKernels avx512{"AVX-512", 200.0 * 200.0, 45e9, factorize_avx512, solve_avx512};
#endif

}  // namespace

TileKernelList runnable_tile_kernels() {
  TileKernelList list{{&plain, nullptr, nullptr}, 1};
#if defined(__x86_64__) && defined(__GNUC__)
  if (processor_instructions() >= Instructions::avx2) list.kernel[list.count++] = &avx2;
  if (processor_instructions() >= Instructions::avx512) list.kernel[list.count++] = &avx512;
#endif
  return list;
}

const TileKernels& best_tile_kernels() {
  static const TileKernelList list = runnable_tile_kernels();
  return *list.kernel[std::min(list.count - 1, static_cast<int>(instructions()))];
}

}  // namespace dccast::linalg
