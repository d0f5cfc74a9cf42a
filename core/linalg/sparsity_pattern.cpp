#include "core/linalg/sparsity_pattern.hpp"

#include <algorithm>

namespace dccast::linalg {

SparsityPattern::SparsityPattern(int unknowns, std::span<const int> element_unknown,
                                 int per_element)
    : per_element_(per_element) {
  const std::size_t width = std::size_t(per_element);
  const std::size_t elements = width == 0 ? 0 : element_unknown.size() / width;
  std::vector<std::vector<int>> rows_of_column(std::size_t(unknowns), std::vector<int>{});
  for (int u = 0; u < unknowns; ++u) rows_of_column[std::size_t(u)].push_back(u);
  for (std::size_t e = 0; e < elements; ++e) {
    const auto unknown = element_unknown.subspan(e * width, width);
    for (int column : unknown) {
      for (int row : unknown) {
        if (column >= 0 && row > column) rows_of_column[std::size_t(column)].push_back(row);
      }
    }
  }
  column_start_.assign(1, 0);
  for (auto& rows : rows_of_column) {
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    row_.insert(row_.end(), rows.begin(), rows.end());
    column_start_.push_back(static_cast<int>(row_.size()));
  }
  place_.assign(elements * width * width, -1);
  for (std::size_t e = 0; e < elements; ++e) {
    const auto unknown = element_unknown.subspan(e * width, width);
    for (std::size_t i = 0; i < width; ++i) {
      for (std::size_t j = 0; j < width; ++j) {
        const int column = std::min(unknown[i], unknown[j]), row = std::max(unknown[i], unknown[j]);
        if (column < 0) continue;
        const auto begin = row_.begin() + column_start_[std::size_t(column)];
        const auto end = row_.begin() + column_start_[std::size_t(column) + 1];
        place_[(e * width + i) * width + j] =
            static_cast<int>(std::lower_bound(begin, end, row) - row_.begin());
      }
    }
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
