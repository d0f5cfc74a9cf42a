#include "core/linalg/band_cholesky.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <numeric>
#include <utility>

namespace dccast::linalg {

namespace {

/// Work of a row of tiles from which a team gains more than its members wait for each other
/// [multiplications and additions]: docs/developers/decisions.md.
constexpr double shared_row_flops = 2e5;

/// Smallest number of rows of tiles that several threads share in a pass through the matrix: some
/// 20 us of one thread.
constexpr std::size_t least_rows_per_call = 20;

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

  sort_entries(pattern);
  whole_ = false;
  tile_.reserve(tiles());
  inverse_.resize(shape_.first.size());
  right_.assign(shape_.first.size(), TileRow{});

  // A solve that streams keeps the sums of as many columns as a column has rows.
  int reach = 0;
  for (int j = 0; j < shape_.rows(); ++j) reach = std::max(reach, shape_.last[std::size_t(j)] - j);
  sums_.assign(streams() ? std::size_t(reach) + 1 : 0, Tile{});
}

void BandCholesky::sort_entries(const SparsityPattern& pattern) {
  row_start_.assign(shape_.first.size() + 1, 0);
  for_each_entry(pattern, place_, [&](std::size_t, int row, int) {
    ++row_start_[std::size_t(row / tile_size) + 1];
  });
  std::partial_sum(row_start_.begin(), row_start_.end(), row_start_.begin());

  source_.resize(pattern.entries());
  target_.resize(pattern.entries());
  std::vector<std::size_t> next(row_start_.begin(), row_start_.end() - 1);
  for_each_entry(pattern, place_, [&](std::size_t k, int row, int column) {
    const std::size_t i = std::size_t(row / tile_size), place = next[i]++;
    const int tile = column / tile_size - shape_.first[i];
    source_[place] = static_cast<int>(k);
    target_[place] = (tile * tile_size + column % tile_size) * tile_size + row % tile_size;
  });
  values_.assign(pattern.entries(), 0.0);
}

bool BandCholesky::streams() const {
  return tiles() * sizeof(Tile) > cache_bytes;
}

std::size_t BandCholesky::memory_bytes() const {
  return tile_.bytes() + (inverse_.size() + right_.size()) * sizeof(TileRow) +
         values_.size() * (2 * sizeof(int) + sizeof(double));
}

bool BandCholesky::has_changed(std::size_t row, std::span<const double> values) const {
  // Compare bitwise: rows of the factor are reused only for identical entries.
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  for (std::size_t k = row_start_[row]; k < row_start_[row + 1]; ++k) {
    if (bits(values[std::size_t(source_[k])]) != bits(values_[k])) return true;
  }
  return false;
}

int BandCholesky::first_changed_row(std::span<const double> values) const {
  if (!whole_) return 0;
  int row = 0;
  while (row < shape_.rows() && !has_changed(std::size_t(row), values)) ++row;
  return row;
}

/// A row of tiles is zeroed just before its entries are set, while it is in the cache. The values
/// are kept, so that the next factorisation finds the first row that changes.
void BandCholesky::copy_row(std::size_t row, std::span<const double> values) {
  Tile* const tiles = tile_.get() + shape_.start[row];
  std::fill(tiles, tile_.get() + shape_.start[row + 1], Tile{});

  double* const number = tiles->entry;
  for (std::size_t k = row_start_[row]; k < row_start_[row + 1]; ++k) {
    values_[k] = values[std::size_t(source_[k])];
    number[target_[k]] = values_[k];
  }
}

void BandCholesky::copy_matrix(std::span<const double> values, int from) {
  const std::size_t first = std::size_t(from), rows = std::size_t(shape_.rows());
  for_each_stretch(rows - first, least_rows_per_call, [&](std::size_t row, std::size_t end) {
    for (; row < end; ++row) copy_row(first + row, values);
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
