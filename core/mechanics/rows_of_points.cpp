#include "core/mechanics/rows_of_points.hpp"

#include <cmath>

#include "core/fem/element.hpp"

namespace dccast::mechanics {

namespace {

/// Integration points of an element on one vertical line, the lower one first.
template <int Dim>
std::array<std::array<std::size_t, 2>, RowsOfPoints<Dim>::points / 2> upright_lines() {
  constexpr std::size_t up = Dim - 1;
  constexpr auto& point = fem::Q1<Dim>::point;
  std::array<std::array<std::size_t, 2>, RowsOfPoints<Dim>::points / 2> lines{};
  std::size_t found = 0;
  for (std::size_t low = 0; low < point.size(); ++low) {
    if (point[low][up] > 0.0) continue;
    auto above = point[low];
    above[up] = -above[up];
    for (std::size_t high = 0; high < point.size(); ++high) {
      if (point[high] == above) lines[found++] = {low, high};
    }
  }
  return lines;
}

/// Weights by which the values at the lower and upper points of two cells, one above the other,
/// give those of the merged cell: the linear function with the same mean and first moment [1].
/// @param height  [m] of the cells @return  (point after, point before, from below)
std::array<std::array<double, 4>, 2> weights(const std::array<double, 2>& height) {
  const double g = 1.0 / std::sqrt(3.0);
  const double low = height[0], high = height[1], whole = low + high;
  // Integral, and first moment about the middle of the whole, of each value.
  const double lever = low * high / 4.0, of_low = low * low / (12.0 * g),
               of_high = high * high / (12.0 * g);
  const std::array<double, 4> integral{low / 2.0, low / 2.0, high / 2.0, high / 2.0};
  const std::array<double, 4> moment{-lever - of_low, -lever + of_low, lever - of_high,
                                     lever + of_high};
  std::array<std::array<double, 4>, 2> weight{};
  for (std::size_t i = 0; i < 4; ++i) {
    const double mean = integral[i] / whole, slope = 6.0 * g * moment[i] / (whole * whole);
    weight[0][i] = mean - slope;
    weight[1][i] = mean + slope;
  }
  return weight;
}

}  // namespace

template <int Dim>
std::array<double, 2> RowsOfPoints<Dim>::heights(std::size_t row) const {
  const auto [low, high] = rows_[row];
  const auto height = [&](std::size_t r) { return merged_.height[r + 1] - merged_.height[r]; };
  return {height(low), low == high ? 0.0 : height(high)};
}

template <int Dim>
template <class Use>
void RowsOfPoints<Dim>::for_each_element(const Use& use) const {
  const std::size_t per_row = merged_.elements_per_row;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    for (std::size_t i = 0; i < per_row; ++i)
      use(row, row * per_row + i, rows_[row][0] * per_row + i, rows_[row][1] * per_row + i);
  }
}

template <int Dim>
bool RowsOfPoints<Dim>::is_pair(std::size_t element) const {
  const auto& row = rows_[element / merged_.elements_per_row];
  return row[0] != row[1];
}

template <int Dim>
std::vector<SymmetricTensor<Dim>> RowsOfPoints<Dim>::projected(
    std::span<const Tensor> field) const {
  static const auto lines = upright_lines<Dim>();
  std::vector<Tensor> after(rows_.size() * merged_.elements_per_row * points);

  for_each_element([&](std::size_t row, std::size_t e, std::size_t low, std::size_t high) {
    if (low == high) {
      for (std::size_t q = 0; q < points; ++q) after[e * points + q] = field[low * points + q];
      return;
    }

    const auto weight = weights(heights(row));
    for (const auto& line : lines) {
      for (std::size_t end = 0; end < 2; ++end) {
        Tensor& value = after[e * points + line[end]];
        for (std::size_t i = 0; i < 4; ++i)
          value.add(weight[end][i], field[(i < 2 ? low : high) * points + line[i % 2]]);
      }
    }
  });
  return after;
}

template <int Dim>
std::vector<double> RowsOfPoints<Dim>::means(std::span<const double> field) const {
  std::vector<double> after(rows_.size() * merged_.elements_per_row * points);
  for_each_element([&](std::size_t row, std::size_t e, std::size_t low, std::size_t high) {
    const auto height = heights(row);
    const double mean = (height[0] * field[low * points] + height[1] * field[high * points]) /
                        (height[0] + height[1]);
    for (std::size_t q = 0; q < points; ++q) after[e * points + q] = mean;
  });
  return after;
}

template <int Dim>
std::vector<double> RowsOfPoints<Dim>::point_means(std::span<const double> field) const {
  static const auto lines = upright_lines<Dim>();
  std::vector<double> after(rows_.size() * merged_.elements_per_row * points);
  for_each_element([&](std::size_t row, std::size_t e, std::size_t low, std::size_t high) {
    const auto height = heights(row);
    if (low == high) {
      for (std::size_t q = 0; q < points; ++q) after[e * points + q] = field[low * points + q];
      return;
    }

    for (const auto& line : lines) {
      const std::size_t lower = line[0], upper = line[1];
      const auto mean = [&](std::size_t element) {
        return 0.5 * (field[element * points + lower] + field[element * points + upper]);
      };
      const double of_line =
          (height[0] * mean(low) + height[1] * mean(high)) / (height[0] + height[1]);
      after[e * points + lower] = after[e * points + upper] = of_line;
    }
  });
  return after;
}

template <int Dim>
std::vector<char> RowsOfPoints<Dim>::all_of(std::span<const char> flag) const {
  std::vector<char> after(rows_.size() * merged_.elements_per_row);
  for_each_element([&](std::size_t, std::size_t e, std::size_t low, std::size_t high) {
    after[e] = flag[low] != 0 && flag[high] != 0 ? 1 : 0;
  });
  return after;
}

template <int Dim>
std::vector<double> RowsOfPoints<Dim>::restricted(std::vector<double> force) const {
  mesh::share_out_rows(merged_, merged_.nodes_per_row * Dim, force);
  return force;
}

template class RowsOfPoints<2>;
template class RowsOfPoints<3>;

}  // namespace dccast::mechanics
