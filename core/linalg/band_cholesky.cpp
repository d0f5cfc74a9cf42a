#include "core/linalg/band_cholesky.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

namespace dccast::linalg {

namespace {

/// Work of a row of tiles from which a team gains more than its members wait for each other
/// [multiplications and additions]: docs/developers/threads.md.
constexpr double shared_row_flops = 2e5;

/// Smallest portions of a pass through a matrix or a factor that several threads share: some 20 us
/// of one thread.
constexpr std::size_t least_entries_per_call = 20'000;
constexpr std::size_t least_tiles_per_call = 500;

/// Calls use(entry, row, column), row >= column, both places in the order of elimination.
template <class Use>
void for_each_entry(const SparsityPattern& pattern, std::span<const int> place, const Use& use) {
  const auto& start = pattern.column_start();
  for (std::size_t c = 0; c + 1 < start.size(); ++c) {
    for (std::size_t k = std::size_t(start[c]); k < std::size_t(start[c + 1]); ++k) {
      const auto [column, row] = std::minmax(place[c], place[std::size_t(pattern.row()[k])]);
      use(k, row, column);
    }
  }
}

}  // namespace

BandShape::BandShape(const SparsityPattern& pattern, std::span<const int> place) {
  const std::size_t count = std::size_t((pattern.unknowns() + tile_size - 1) / tile_size);
  first.resize(count);
  for (std::size_t i = 0; i < count; ++i) first[i] = static_cast<int>(i);
  for_each_entry(pattern, place, [&](std::size_t, int row, int column) {
    int& reach = first[std::size_t(row / tile_size)];
    reach = std::min(reach, column / tile_size);
  });
  // The envelope is monotone: a row reaches at least as far as all rows below it.
  for (std::size_t i = count; i-- > 1;) first[i - 1] = std::min(first[i - 1], first[i]);

  last.resize(count);
  start.assign(1, 0);
  constexpr double products = 2.0 * tile_size * tile_size * tile_size;
  for (std::size_t i = 0; i < count; ++i) {
    const int width = static_cast<int>(i) - first[i] + 1;
    start.push_back(start.back() + std::size_t(width));
    flops += products * 0.5 * width * (width + 1.0);
    const int next = i + 1 < count ? first[i + 1] : static_cast<int>(count);
    for (int j = first[i]; j < next; ++j) last[std::size_t(j)] = static_cast<int>(i);
  }
}

void BandCholesky::analyze(const SparsityPattern& pattern, std::span<const int> place) {
  analyze(pattern, place, BandShape(pattern, place));
}

void BandCholesky::analyze(const SparsityPattern& pattern, std::span<const int> place,
                           BandShape shape) {
  shape_ = std::move(shape);
  place_.assign(place.begin(), place.end());

  entry_.resize(pattern.entries());
  entry_row_.resize(pattern.entries());
  for_each_entry(pattern, place, [&](std::size_t k, int row, int column) {
    const std::size_t i = std::size_t(row / tile_size);
    const std::size_t tile = shape_.start[i] + std::size_t(column / tile_size - shape_.first[i]);
    entry_[k] = tile * tile_size * tile_size +
                std::size_t(column % tile_size * tile_size + row % tile_size);
    entry_row_[k] = row / tile_size;
  });

  values_.assign(pattern.entries(), 0.0);
  whole_ = false;
  tile_.reserve(tiles());
  inverse_.resize(shape_.first.size());
  right_.assign(shape_.first.size(), TileRow{});

  // A solve that streams keeps the sums of as many columns as a column has rows.
  int reach = 0;
  for (int j = 0; j < shape_.rows(); ++j) reach = std::max(reach, shape_.last[std::size_t(j)] - j);
  sums_.assign(streams() ? std::size_t(reach) + 1 : 0, Tile{});
}

bool BandCholesky::streams() const {
  return tiles() * sizeof(Tile) > cache_bytes;
}

std::size_t BandCholesky::memory_bytes() const {
  return tile_.bytes() + (inverse_.size() + right_.size()) * sizeof(TileRow) +
         entry_.size() * (sizeof(std::size_t) + sizeof(int) + sizeof(double));
}

int BandCholesky::first_changed_row(std::span<const double> values) const {
  if (!whole_) return 0;
  std::atomic<int> first{shape_.rows()};
  for_each_stretch(values.size(), least_entries_per_call, [&](std::size_t k, std::size_t end) {
    int row = shape_.rows();
    for (; k < end; ++k) {
      // Compare bitwise: rows of the factor are reused only for identical entries.
      const bool same =
          std::bit_cast<std::uint64_t>(values[k]) == std::bit_cast<std::uint64_t>(values_[k]);
      if (!same) row = std::min(row, entry_row_[k]);
    }

    // Atomic minimum.
    for (int lowest = first; row < lowest && !first.compare_exchange_weak(lowest, row);) {
    }
  });
  return first;
}

/// Copies the entries from a row of tiles on, and sets the diagonal past the last unknown to one.
void BandCholesky::copy_matrix(std::span<const double> values, int from) {
  Tile* const first = tile_.get() + shape_.start[std::size_t(from)];
  const std::size_t count = tiles() - shape_.start[std::size_t(from)];
  for_each_stretch(count, least_tiles_per_call, [&](std::size_t begin, std::size_t end) {
    std::fill(first + begin, first + end, Tile{});
  });

  // The values are kept, so that the next factorisation finds the first row that changes.
  double* number = tile_.get()->entry;
  for_each_stretch(values.size(), least_entries_per_call, [&](std::size_t k, std::size_t end) {
    for (; k < end; ++k) {
      if (entry_row_[k] >= from) number[entry_[k]] = values[k];
      values_[k] = values[k];
    }
  });

  for (std::size_t u = place_.size(); u < right_.size() * tile_size; ++u) {
    tile_[tiles() - 1].entry[u % tile_size * (tile_size + 1)] = 1.0;
  }
}

TileBand BandCholesky::band() {
  return {tile_.get(),
          shape_.start.data(),
          shape_.first.data(),
          shape_.last.data(),
          inverse_.data(),
          shape_.rows(),
          streams() ? sums_.data() : nullptr,
          static_cast<int>(sums_.size())};
}

bool BandCholesky::factorize(std::span<const double> values) {
  const int from = first_changed_row(values), rows = shape_.rows();
  share_computed_ = rows > 0 ? static_cast<double>(rows - from) / rows : 0.0;
  if (from == rows) return true;

  copy_matrix(values, from);
  whole_ = factorize_from(from);
  return whole_;
}

bool BandCholesky::is_worth_sharing() const {
  return team_members() > 1 && shape_.flops > shared_row_flops * shape_.rows();
}

bool BandCholesky::factorize_from(int row) {
  if (!is_worth_sharing()) return kernels_->factorize(band(), row, {});
  Progress factorized(row - 1);
  std::atomic<bool> positive{true};
  together([&](int member, int members) {
    const BandShare share{member, members, &factorized};
    if (!kernels_->factorize(band(), row, share)) positive = false;
  });
  return positive;
}

double BandCholesky::share_to_repeat(int unknown) const {
  const int row = place_[std::size_t(unknown)] / tile_size;
  return static_cast<double>(shape_.rows() - row) / shape_.rows();
}

void BandCholesky::solve(std::span<const double> b, std::span<double> x) {
  double* right = right_.data()->entry;
  for (std::size_t u = 0; u < place_.size(); ++u) right[place_[u]] = b[u];
  for (std::size_t u = place_.size(); u < right_.size() * tile_size; ++u) right[u] = 0.0;

  // Members of the team share rows and follow each other's progress.
  if (is_worth_sharing() && streams()) {
    Progress forward(-1), backward(0);
    together([&](int member, int members) {
      kernels_->solve(band(), right_.data(), {member, members, nullptr, &forward, &backward});
    });
  } else {
    kernels_->solve(band(), right_.data(), {});
  }

  for (std::size_t u = 0; u < place_.size(); ++u) x[u] = right[place_[u]];
}

}  // namespace dccast::linalg
