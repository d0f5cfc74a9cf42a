#include "core/linalg/two_grid.hpp"

#include <algorithm>
#include <array>

namespace dccast::linalg {

namespace {

/// Of a diagonal [1]: as much larger than round-off as it is smaller than what the grids leave.
constexpr double indefinite_share = 1e-9;

/// (element, unknown) of an extruded mesh with the given number of rows of nodes.
template <int N>
std::vector<int> list_element_unknowns(const mesh::Extrusion& extruded, int rows) {
  std::vector<int> unknown;
  for (int row = 0; row + 1 < rows; ++row) {
    for (std::size_t c = 0; c < extruded.cell.size(); c += 4) {
      for (int level = 0; level < 2; ++level) {
        for (std::size_t i = 0; i < 4; ++i) {
          const int node = (row + level) * extruded.lines + extruded.cell[c + i];
          for (int d = 0; d < N; ++d) unknown.push_back(node * N + d);
        }
      }
    }
  }
  return unknown;
}

}  // namespace

template <int N>
void TwoGrid<N>::choose_rows(const mesh::Extrusion& extruded, double group) {
  const int rows = extruded.rows();
  double least = extruded.height[1] - extruded.height[0];
  for (int k = 1; k < rows; ++k)
    least = std::min(least, extruded.height[std::size_t(k)] - extruded.height[std::size_t(k) - 1]);

  // A coarse row as soon as the next row would make the cell too high.
  std::vector<int> chosen{0};
  for (int k = 1; k + 1 < rows; ++k) {
    const double above =
        extruded.height[std::size_t(k) + 1] - extruded.height[std::size_t(chosen.back())];
    if (above > group * least * (1.0 + 1e-9)) chosen.push_back(k);
  }
  chosen.push_back(rows - 1);

  // Linear interpolation between the coarse rows.
  between_.assign(std::size_t(rows), {});
  for (std::size_t c = 0; c + 1 < chosen.size(); ++c) {
    const double from = extruded.height[std::size_t(chosen[c])];
    const double whole = extruded.height[std::size_t(chosen[c + 1])] - from;
    for (int k = chosen[c]; k < chosen[c + 1]; ++k) {
      between_[std::size_t(k)] = {int(c), (extruded.height[std::size_t(k)] - from) / whole};
    }
  }
  between_.back() = {int(chosen.size()) - 1, 0.0};
}

template <int N>
void TwoGrid<N>::analyze(const mesh::Extrusion& extruded, double group) {
  choose_rows(extruded, group);

  // The coarse grid has all lines of the fine one, but only the chosen rows.
  layout_ = LineLayout<N>(extruded);
  const int coarse_rows = between_.back().lower + 1;
  mesh::Extrusion coarse{{}, extruded.lines, extruded.cell};
  coarse.height.resize(std::size_t(coarse_rows));
  coarse_layout_ = LineLayout<N>(coarse);

  const auto unknown = list_element_unknowns<N>(extruded, coarse_rows);
  coarse_pattern_ = SparsityPattern(coarse_rows * extruded.lines * N, unknown, 8 * N);
  coarse_solver_.analyze(coarse_pattern_, Geometry::solid);
  coarse_values_.assign(coarse_pattern_.entries(), 0.0);
  coarse_.assign(std::size_t(coarse_pattern_.unknowns()), 0.0);

  lines_.start(layout_);
  for (auto* v : {&right_, &solution_, &residual_}) v->assign(lines_.size(), 0.0F);
}

template <int N>
bool TwoGrid<N>::factorize(const SparsityPattern& pattern, std::span<const double> values,
                           std::span<const char> held) {
  lines_.start(layout_);
  const std::size_t pair_size = std::size_t(LineLayout<N>::entries) * coarse_layout_.stride();
  coarse_own_.assign(std::size_t(layout_.lines()) * pair_size, 0.0);
  coarse_coupling_.assign(layout_.pairs() * pair_size, 0.0);
  for (int line = 0; line < layout_.lines(); ++line) {
    for (int row = 0; row < layout_.rows(); ++row) assemble_node(line, row, pattern, values, held);
  }
  return lines_.factorize() && factorize_coarse();
}

/// Adds the diagonal block of a node and the blocks below it in its columns to both grids.
template <int N>
void TwoGrid<N>::assemble_node(int line, int row, const SparsityPattern& pattern,
                               std::span<const double> values, std::span<const char> held) {
  const auto& start = pattern.column_start();
  const int node = row * layout_.lines() + line;
  std::array<const double*, N> column;
  std::array<double, N * N> block;
  for (std::size_t d = 0; d < N; ++d) {
    column[d] = values.data() + start[std::size_t(node) * N + d];
    for (std::size_t i = d; i < N; ++i) block[i * N + d] = block[d * N + i] = column[d][i - d];
    column[d] += N - d;
  }

  // The lines contain held unknowns, the coarse problem does not.
  const auto add = [&](int other) {
    const int lines = layout_.lines();
    const Place place = layout_.place(other % lines, other / lines, line, row);
    lines_.add(place, block.data());
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t d = 0; d < N; ++d) {
        if (held[std::size_t(node) * N + d] != 0 || held[std::size_t(other) * N + i] != 0)
          block[i * N + d] = 0.0;
      }
    }
    add_coarse(place, block.data());
  };

  add(node);
  const int first = start[std::size_t(node) * N] + N, end = start[std::size_t(node) * N + 1];
  for (int k = first; k < end; k += N) {
    for (std::size_t d = 0; d < N; ++d) {
      for (std::size_t i = 0; i < N; ++i) block[i * N + d] = column[d][std::size_t(k - first) + i];
    }
    add(pattern.row()[std::size_t(k)] / N);
  }
}

/// Adds a block P' A P to all blocks between the coarse rows on either side of its rows. Blocks of
/// a line with itself are stored with the upper row.
template <int N>
void TwoGrid<N>::add_coarse(const Place& place, const double* block) {
  const bool diagonal = place.one_line && place.below == 1;
  const Between& own = between_[std::size_t(place.row)];
  const Between& next = between_[std::size_t(place.row + place.below - 1)];

  // Entries of P on both sides: a fine row lies between two coarse rows.
  for (int i = 0; i < 2; ++i) {
    const double share = i == 0 ? 1.0 - own.upper : own.upper;
    for (int j = 0; j < 2; ++j) {
      const double weight = share * (j == 0 ? 1.0 - next.upper : next.upper);
      if (weight == 0.0) continue;
      const int row = own.lower + i, other = next.lower + j;

      if (!place.one_line) {
        add_to_coarse({place.pair, row, other - row + 1, place.transposed, false}, weight, block);
        continue;
      }
      if (row >= other)
        add_to_coarse({place.pair, row, other - row + 1, false, true}, weight, block);
      if (row <= other && !diagonal)
        add_to_coarse({place.pair, other, row - other + 1, true, true}, weight, block);
    }
  }
}

template <int N>
void TwoGrid<N>::add_to_coarse(const Place& place, double share, const double* block) {
  auto& values = place.one_line ? coarse_own_ : coarse_coupling_;
  const auto slot = coarse_layout_.block(place);
  for (int a = 0; a < N; ++a) {
    for (int b = 0; b < N; ++b) values[slot(a, b)] += share * block[a * N + b];
  }
}

template <int N>
bool TwoGrid<N>::factorize_coarse() {
  const auto& start = coarse_pattern_.column_start();
  const int lines = layout_.lines();
  for (int c = 0; c < coarse_pattern_.unknowns(); ++c) {
    const int node = c / N;
    for (int k = start[std::size_t(c)]; k < start[std::size_t(c) + 1]; ++k) {
      const int r = coarse_pattern_.row()[std::size_t(k)], other = r / N;
      const auto place =
          coarse_layout_.place(other % lines, other / lines, node % lines, node / lines);
      const auto& from = place.one_line ? coarse_own_ : coarse_coupling_;
      double value = from[coarse_layout_.block(place)(r % N, c % N)];

      // All fine unknowns that it represents are held. Where but one of several is not, coarse ones
      // move the same: the share keeps the matrix definite and does not reach the fine grid.
      if (r == c) value = value > 0.0 ? (1.0 + indefinite_share) * value : 1.0;
      coarse_values_[std::size_t(k)] = value;
    }
  }
  return coarse_solver_.factorize(coarse_values_);
}

template <int N>
void TwoGrid<N>::restrict_residual() {
  std::fill(coarse_.begin(), coarse_.end(), 0.0);
  const std::size_t lines = std::size_t(layout_.lines());
  for (std::size_t line = 0; line < lines; ++line) {
    for (std::size_t a = 0; a < N; ++a) {
      const float* r = &residual_[lines_.first_row(int(line), int(a))];

      // P' r: a fine row gives its residual to the two coarse rows around it.
      for (std::size_t k = 0; k < between_.size(); ++k) {
        const Between& row = between_[k];
        const std::size_t to = (std::size_t(row.lower) * lines + line) * N + a;
        coarse_[to] += (1.0 - row.upper) * r[k];
        if (row.upper > 0.0) coarse_[to + lines * N] += row.upper * r[k];
      }
    }
  }
}

template <int N>
void TwoGrid<N>::interpolate_correction() {
  const std::size_t lines = std::size_t(layout_.lines());
  for (std::size_t line = 0; line < lines; ++line) {
    for (std::size_t a = 0; a < N; ++a) {
      float* x = &solution_[lines_.first_row(int(line), int(a))];

      // P e: a fine row takes the mean of the two coarse corrections around it, by distance.
      for (std::size_t k = 0; k < between_.size(); ++k) {
        const Between& row = between_[k];
        const std::size_t from = (std::size_t(row.lower) * lines + line) * N + a;
        double e = (1.0 - row.upper) * coarse_[from];
        if (row.upper > 0.0) e += row.upper * coarse_[from + lines * N];
        x[k] += static_cast<float>(e);
      }
    }
  }
}

template <int N>
void TwoGrid<N>::apply(std::span<const double> r, std::span<double> z) {
  const std::size_t lines = std::size_t(layout_.lines()), rows = between_.size();
  const auto for_each_unknown = [&](auto&& use) {
    for (std::size_t line = 0; line < lines; ++line) {
      for (std::size_t a = 0; a < N; ++a) {
        const std::size_t first = lines_.first_row(int(line), int(a));
        for (std::size_t k = 0; k < rows; ++k) use((k * lines + line) * N + a, first + k);
      }
    }
  };

  // Symmetric cycle: relax forwards, correct on the coarse grid, relax backwards.
  for_each_unknown([&](std::size_t u, std::size_t i) { right_[i] = static_cast<float>(r[u]); });
  lines_.forward(right_, solution_, residual_);
  restrict_residual();
  coarse_solver_.solve(coarse_, coarse_);
  interpolate_correction();
  lines_.backward(right_, solution_);
  for_each_unknown([&](std::size_t u, std::size_t i) { z[u] = solution_[i]; });
}

template <int N>
std::size_t TwoGrid<N>::memory_bytes() const {
  const std::size_t coarse_numbers =
      coarse_own_.size() + coarse_coupling_.size() + coarse_values_.size() + coarse_.size();
  return lines_.memory_bytes() + coarse_numbers * sizeof(double) +
         3 * right_.size() * sizeof(float) + coarse_solver_.memory_bytes();
}

template class TwoGrid<3>;

}  // namespace dccast::linalg
