#include "core/linalg/tile_kernels.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <new>

#include "core/base/instructions.hpp"
#include "core/linalg/tile_operations.hpp"

namespace dccast::linalg {

namespace {

using namespace tiles;

/// Progress value of a factorisation by several members after a pivot was not positive.
constexpr int no_factor = std::numeric_limits<int>::max();

/// Computes the diagonal tile of a row whose other tiles are complete, and reports it to the
/// members that wait for its column.
template <int Lanes>
DCCAST_INLINE bool finish_row(const TileBand& band, int j, const BandShare& share) {
  const int first = band.first[j];
  Tile& tile = *band.at(j, j);
  subtract_products<Lanes>(band.at(j, first), band.at(j, first), j - first, tile);
  const bool positive = factorize_tile<Lanes>(tile, band.inverse[j]);
  if (share.factorized != nullptr) share.factorized->reach(positive ? j : no_factor);
  return positive;
}

/// Factorises column by column of tiles, from the left: the rows of one column do not depend on
/// each other. The row below the diagonal comes first and is finished at once, so that the next
/// column can begin while this one continues.
template <int Lanes>
DCCAST_INLINE bool factorize_band(const TileBand& band, int from, const BandShare& share) {
  for (int j = from < band.rows ? band.first[from] : band.rows; j < band.rows; ++j) {
    // A diagonal row without predecessors begins a part of its own.
    const bool begins = band.first[j] == j && j >= from;
    if (begins && share.owns(j) && !finish_row<Lanes>(band, j, share)) return false;
    if (share.factorized != nullptr && share.factorized->wait_for(j) == no_factor) return false;

    // The rows below the diagonal are shared among the members.
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

/// x <- L^-1 x in a row of tiles, given the rows before.
template <int Lanes>
DCCAST_INLINE void forward(const TileBand& band, int i, TileRow* x, const BandShare& share) {
  constexpr int parts = tile_size / Lanes, chains = Lanes / 2;
  typename Register<Lanes>::type sum[chains][parts] = {};
  const int first = band.first[i];

  // The member's own previous row is complete, and with it all rows before that.
  const int late = first > i - share.members + 1 ? first : i - share.members + 1;
  add_products<Lanes>(band.at(i, first), x + first, late - first, sum);
  if (share.forward != nullptr) share.forward->wait_for(i - 1);
  add_products<Lanes>(band.at(i, late), x + late, i - late, sum);

  for (int c = 0; c < chains; ++c) {
    for (int p = 0; p < parts; ++p) rows_at<Lanes>(x[i].entry + Lanes * p) -= sum[c][p];
  }
  substitute_forward(*band.at(i, i), band.inverse[i], x[i]);
  if (share.forward != nullptr) share.forward->reach(i);
}

/// x <- (L')^-1 x in a row of tiles, given the rows after.
template <int Lanes>
DCCAST_INLINE void backward(const TileBand& band, int j, TileRow* x) {
  constexpr int parts = tile_size / Lanes, pass = tile_size / parts;
  for (int k0 = 0; k0 < tile_size; k0 += pass) {
    typename Register<Lanes>::type sum[pass][parts] = {};
    // Sums over the rows after, which are known.
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
  substitute_back(*band.at(j, j), band.inverse[j], x[j]);
}

/// x <- (L')^-1 x in a row of tiles, given the sums of the products of the rows after.
DCCAST_INLINE void finish_column(const TileBand& band, int j, TileRow* x, const BandShare& share) {
  Tile& own = band.sums[j % band.sum_columns];
  subtract_sums(own, x[j]);
  own = Tile{};
  substitute_back(*band.at(j, j), band.inverse[j], x[j]);
  if (share.backward != nullptr) share.backward->reach(band.rows - j);
}

/// x <- (L')^-1 x, row by row from the last one: each row adds its products to the sums of the
/// columns before it. All tiles are read from the last one down, at the full bandwidth of the
/// memory; column by column it would be a third of that. The column before a row is finished first,
/// so that the next row can begin while this one continues.
template <int Lanes>
DCCAST_INLINE void backward_streaming(const TileBand& band, TileRow* x, const BandShare& share) {
  constexpr int parts = tile_size / Lanes;
  for (int j = band.rows - 1; j >= 0; --j) {
    if (band.last[j] == j && share.owns(j)) finish_column(band, j, x, share);
    if (share.backward != nullptr) share.backward->wait_for(band.rows - j);

    // The row is finished: it now contributes to all columns before it.
    typename Register<Lanes>::type found[parts];
    for (int p = 0; p < parts; ++p) found[p] = rows_at<Lanes>(x[j].entry + Lanes * p);

    for (int c = share.last_up_to(j - 1); c >= band.first[j]; c -= share.members) {
      const Tile* tile = band.at(j, c);
      double* sum = band.sums[c % band.sum_columns].entry;
      for (int k = tile_size - 1; k >= 0; --k) {
        for (int p = 0; p < parts; ++p) {
          const int entry = tile_size * k + Lanes * p;
          rows_at<Lanes>(sum + entry) += rows_at<Lanes>(tile->entry + entry) * found[p];
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

constexpr std::size_t huge_page = std::size_t(2) << 20;  // [byte]

/// Memory for tiles, in huge pages if a factor of this size does not fit in the cache. Null if
/// there is none.
Tile* allocate(std::size_t tiles) {
  const std::size_t bytes = tiles * sizeof(Tile);
  if (bytes < cache_bytes) return static_cast<Tile*>(std::aligned_alloc(alignof(Tile), bytes));

  const std::size_t whole = (bytes + huge_page - 1) / huge_page * huge_page;
  void* storage = std::aligned_alloc(huge_page, whole);
#ifdef MADV_HUGEPAGE
  if (storage != nullptr) madvise(storage, whole, MADV_HUGEPAGE);
#endif
  return static_cast<Tile*>(storage);
}

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

void TileStorage::reserve(std::size_t tiles) {
  if (tiles <= capacity_) return;
  const std::size_t capacity = capacity_ == 0 ? tiles : tiles + tiles / 4;

  // The old tiles are released first: both together may not fit in memory.
  capacity_ = 0;
  tile_.reset();
  tile_.reset(allocate(capacity));
  if (tile_ == nullptr) throw std::bad_alloc();
  capacity_ = capacity;
}

void TileStorage::Free::operator()(Tile* tiles) const {
  std::free(tiles);
}

}  // namespace dccast::linalg
