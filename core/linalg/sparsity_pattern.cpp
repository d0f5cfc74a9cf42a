#include "core/linalg/sparsity_pattern.hpp"

#include <algorithm>

namespace dccast::linalg {

namespace {

/// Where each unknown stands in the list of the elements' unknowns.
struct Incidence {
  std::vector<int> start, position;

  Incidence(int unknowns, std::span<const int> element_unknown) {
    start.assign(std::size_t(unknowns) + 1, 0);
    for (const int u : element_unknown) {
      if (u >= 0) ++start[std::size_t(u) + 1];
    }
    for (std::size_t u = 0; u + 1 < start.size(); ++u) start[u + 1] += start[u];
    position.resize(std::size_t(start.back()));
    std::vector<int> next(start.begin(), start.end() - 1);
    for (std::size_t i = 0; i < element_unknown.size(); ++i) {
      const int u = element_unknown[i];
      if (u >= 0) position[std::size_t(next[std::size_t(u)]++)] = static_cast<int>(i);
    }
  }
  /// Calls use(element, number within it) for every element of an unknown.
  template <class Use>
  void for_each_element(int unknown, std::size_t per_element, const Use& use) const {
    const std::size_t u = std::size_t(unknown);
    for (int k = start[u]; k < start[u + 1]; ++k) {
      const std::size_t at = std::size_t(position[std::size_t(k)]);
      use(at / per_element, at % per_element);
    }
  }
};

}  // namespace

SparsityPattern::SparsityPattern(int unknowns, std::span<const int> element_unknown,
                                 int per_element)
    : per_element_(per_element) {
  const std::size_t width = std::size_t(per_element);
  const std::size_t elements = width == 0 ? 0 : element_unknown.size() / width;
  const Incidence incidence(unknowns, element_unknown);
  place_.assign(elements * width * width, -1);
  std::vector<int> column_of(std::size_t(unknowns), -1), place_of(std::size_t(unknowns), -1);
  for (int column = 0; column < unknowns; ++column) {
    const auto diagonal = static_cast<std::ptrdiff_t>(row_.size());
    row_.push_back(column);
    incidence.for_each_element(column, width, [&](std::size_t e, std::size_t) {
      for (const int row : element_unknown.subspan(e * width, width)) {
        if (row <= column || column_of[std::size_t(row)] == column) continue;
        column_of[std::size_t(row)] = column;
        row_.push_back(row);
      }
    });
    std::sort(row_.begin() + diagonal, row_.end());
    for (auto k = std::size_t(diagonal); k < row_.size(); ++k) {
      place_of[std::size_t(row_[k])] = static_cast<int>(k);
    }
    incidence.for_each_element(column, width, [&](std::size_t e, std::size_t i) {
      for (std::size_t j = 0; j < width; ++j) {
        const int row = element_unknown[e * width + j];
        if (row < column) continue;
        const int place = place_of[std::size_t(row)];
        place_[(e * width + i) * width + j] = place_[(e * width + j) * width + i] = place;
      }
    });
    column_start_.push_back(static_cast<int>(row_.size()));
  }
}

void multiply(const SparsityPattern& pattern, std::span<const double> values,
              std::span<const double> x, std::span<double> y) {
  std::fill(y.begin(), y.end(), 0.0);
  const auto& start = pattern.column_start();
  const auto& row = pattern.row();
  for (std::size_t c = 0; c + 1 < start.size(); ++c) {
    y[c] += values[std::size_t(start[c])] * x[c];
    for (std::size_t k = std::size_t(start[c]) + 1; k < std::size_t(start[c + 1]); ++k) {
      const std::size_t r = std::size_t(row[k]);
      y[r] += values[k] * x[c];
      y[c] += values[k] * x[r];
    }
  }
}

}  // namespace dccast::linalg
