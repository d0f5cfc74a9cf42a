#include "core/linalg/sparsity_pattern.hpp"

#include <algorithm>
#include <cstddef>

#include "core/base/team.hpp"

namespace dccast::linalg {

namespace {

/// Positions of each unknown, from a first one on, in the list of the elements' unknowns.
struct Incidence {
  int first;
  std::vector<int> start, position;

  Incidence(int first_unknown, int unknowns, std::span<const int> element_unknown)
      : first(first_unknown) {
    start.assign(std::size_t(unknowns - first) + 1, 0);
    for (const int u : element_unknown) {
      if (u >= first) ++start[std::size_t(u - first) + 1];
    }
    for (std::size_t u = 0; u + 1 < start.size(); ++u) start[u + 1] += start[u];

    // Counting sort of the positions by unknown.
    position.resize(std::size_t(start.back()));
    std::vector<int> next(start.begin(), start.end() - 1);
    for (std::size_t i = 0; i < element_unknown.size(); ++i) {
      const int u = element_unknown[i];
      if (u >= first) position[std::size_t(next[std::size_t(u - first)]++)] = static_cast<int>(i);
    }
  }

  /// Calls use(element, number within it) for every element of an unknown.
  template <class Use>
  void for_each_element(int unknown, std::size_t per_element, const Use& use) const {
    const std::size_t u = std::size_t(unknown - first);
    for (int k = start[u]; k < start[u + 1]; ++k) {
      const std::size_t entry = std::size_t(position[std::size_t(k)]);
      use(entry / per_element, entry % per_element);
    }
  }
};

constexpr int most_parts = 16;
/// A product of a smaller matrix takes some 20 us, which is not worth sharing.
constexpr std::size_t entries_to_divide = 50'000;

/// First columns of equal parts of a matrix with three unknowns per node, and the end of the last.
std::vector<int> equal_parts(int nodes, int parts) {
  std::vector<int> first;
  for (int part = 0; part <= parts; ++part) first.push_back(3 * (nodes * part / parts));
  return first;
}

/// Adds the part of a product that belongs to the columns of a node with N unknowns. For a node in
/// 3D this was measured to take 0.3 to 0.45 of the time of single entries; in 2D it gains little.
template <int N>
void add_product_of_node(const SparsityPattern& pattern, std::span<const double> values,
                         std::span<const double> x, std::size_t first, std::span<double> y) {
  const auto& start = pattern.column_start();
  const double* column[N];
  double from[N], sum[N] = {};

  // Diagonal block. The sums of the node's own rows stay in registers to the end.
  for (std::size_t d = 0; d < N; ++d) {
    column[d] = values.data() + start[first + d];
    from[d] = x[first + d];
    sum[d] += column[d][0] * from[d];
    for (std::size_t i = d + 1; i < N; ++i) {
      y[first + i] += column[d][i - d] * from[d];
      sum[d] += column[d][i - d] * x[first + i];
    }
    column[d] += N - d;
  }

  // Blocks below it, and by symmetry those to the right of it.
  const int* row = pattern.row().data() + start[first] + N;
  const std::size_t below = std::size_t(start[first + 1] - start[first]) - N;
  for (std::size_t k = 0; k < below; k += N) {
    const std::size_t r = std::size_t(row[k]);
    for (std::size_t i = 0; i < N; ++i) {
      double along = 0.0;
      for (std::size_t d = 0; d < N; ++d) {
        along += column[d][k + i] * from[d];
        sum[d] += column[d][k + i] * x[r + i];
      }
      y[r + i] += along;
    }
  }
  for (std::size_t d = 0; d < N; ++d) y[first + d] += sum[d];
}

/// Adds the part of a product that belongs to one column, entry by entry.
void add_product_of_column(const SparsityPattern& pattern, std::span<const double> values,
                           std::span<const double> x, std::size_t c, std::span<double> y) {
  const auto& start = pattern.column_start();
  y[c] += values[std::size_t(start[c])] * x[c];
  for (std::size_t k = std::size_t(start[c]) + 1; k < std::size_t(start[c + 1]); ++k) {
    const std::size_t r = std::size_t(pattern.row()[k]);
    y[r] += values[k] * x[c];
    y[c] += values[k] * x[r];
  }
}

}  // namespace

SparsityPattern::SparsityPattern(int unknowns, std::span<const int> element_unknown,
                                 int per_element)
    : per_element_(per_element) {
  extend(unknowns, element_unknown);
}

void SparsityPattern::extend(int new_unknowns, std::span<const int> element_unknown) {
  const std::size_t width = std::size_t(per_element_);
  const std::size_t elements = width == 0 ? 0 : element_unknown.size() / width;
  const std::size_t known = width == 0 ? 0 : place_.size() / width;
  int first = unknowns();
  for (const int u : element_unknown.subspan(known)) {
    if (u >= 0) first = std::min(first, u);
  }

  // Columns before the lowest unknown of a new element stay as they are.
  column_start_.resize(std::size_t(first) + 1);
  row_.resize(std::size_t(column_start_.back()));
  place_.resize(elements * width * width, -1);

  const Incidence incidence(first, new_unknowns, element_unknown);
  const std::size_t count = std::size_t(new_unknowns);
  std::vector<int> last_column(count, -1), row_place(count, -1);
  for (int column = first; column < new_unknowns; ++column) {
    // Rows: the unknowns that share an element with the column, each once.
    const auto diagonal = static_cast<std::ptrdiff_t>(row_.size());
    row_.push_back(column);
    incidence.for_each_element(column, width, [&](std::size_t e, std::size_t) {
      for (const int row : element_unknown.subspan(e * width, width)) {
        if (row <= column || last_column[std::size_t(row)] == column) continue;
        last_column[std::size_t(row)] = column;
        row_.push_back(row);
      }
    });
    std::sort(row_.begin() + diagonal, row_.end());

    for (auto k = std::size_t(diagonal); k < row_.size(); ++k) {
      row_place[std::size_t(row_[k])] = static_cast<int>(k);
    }
    incidence.for_each_element(column, width, [&](std::size_t e, std::size_t i) {
      for (std::size_t j = 0; j < width; ++j) {
        const int row = element_unknown[e * width + j];
        if (row < column) continue;
        const int place = row_place[std::size_t(row)];
        place_[(e * width + i) * width + j] = place_[(e * width + j) * width + i] = place;
      }
    });
    column_start_.push_back(static_cast<int>(row_.size()));
  }

  find_unknowns_per_node(first);
  find_parts();
}

void SparsityPattern::find_parts() {
  part_ = {0, unknowns()};
  if (unknowns_per_node_ != 3 || entries() < entries_to_divide) return;
  for (int parts = most_parts; parts >= 4; parts /= 2) {
    std::vector<int> divided = equal_parts(unknowns() / 3, parts);
    if (is_divided_by(divided)) return part_.swap(divided);
  }
}

bool SparsityPattern::is_divided_by(const std::vector<int>& part) const {
  for (std::size_t p = 0; p + 3 < part.size(); ++p) {
    for (int c = part[p]; c < part[p + 1]; ++c) {
      if (row_[std::size_t(column_start_[std::size_t(c) + 1]) - 1] >= part[p + 2]) return false;
    }
  }
  return true;
}

/// @param first  first column that was rebuilt
void SparsityPattern::find_unknowns_per_node(int first) {
  const int before = unknowns_per_node_;
  unknowns_per_node_ = 1;
  for (const int per_node : {3, 2}) {
    if (unknowns_per_node_ != 1) return;
    const int from = per_node == before ? first / per_node * per_node : 0;
    if (is_made_of_nodes(per_node, from)) unknowns_per_node_ = per_node;
  }
}

/// Whether the column of a node's first unknown is that of the next unknown with one entry more,
/// and the rows below come in whole nodes.
bool SparsityPattern::is_made_of_nodes(int per_node, int first_column) const {
  if (unknowns() % per_node != 0) return false;
  const auto column = [&](int c) {
    return std::span(row_).subspan(std::size_t(diagonal(c)),
                                   std::size_t(column_start_[std::size_t(c) + 1] - diagonal(c)));
  };

  for (int c = first_column; c < unknowns(); c += per_node) {
    const auto first = column(c);
    if (first.size() % std::size_t(per_node) != 0) return false;
    for (std::size_t k = 0; k < first.size(); ++k) {
      const std::size_t along = k % std::size_t(per_node);
      if (first[k] % per_node != int(along) || first[k] != first[k - along] + int(along))
        return false;
    }

    // The other columns of the node: the first one without its leading entries.
    for (int d = 1; d < per_node; ++d) {
      if (!std::ranges::equal(first.subspan(std::size_t(d)), column(c + d))) return false;
    }
  }
  return true;
}

void multiply(const SparsityPattern& pattern, std::span<const double> values,
              std::span<const double> x, std::span<double> y) {
  std::fill(y.begin(), y.end(), 0.0);
  if (pattern.unknowns_per_node() == 3) {
    const std::vector<int>& part = pattern.parts();
    const auto add_part = [&](std::size_t p) {
      for (int c = part[p]; c < part[p + 1]; c += 3)
        add_product_of_node<3>(pattern, values, x, std::size_t(c), y);
    };

    // Neither two even parts nor two odd ones write to the same row.
    const std::size_t parts = part.size() - 1;
    for_each_part((parts + 1) / 2, [&](std::size_t pair) { add_part(2 * pair); });
    for_each_part(parts / 2, [&](std::size_t pair) { add_part(2 * pair + 1); });
  } else {
    for (std::size_t c = 0; c < x.size(); ++c) add_product_of_column(pattern, values, x, c, y);
  }
}

NodeGraph::Sweep NodeGraph::sweep_from(std::span<const int> front) const {
  Sweep sweep{{}, std::vector<int>(std::size_t(nodes_), -1)};
  sweep.order.reserve(sweep.distance.size());
  const auto reach = [&](int node, int steps) {
    if (sweep.distance[std::size_t(node)] >= 0) return;
    sweep.distance[std::size_t(node)] = steps;
    sweep.order.push_back(node);
  };

  std::size_t next = 0;
  const auto visit_neighbours = [&] {
    for (; next < sweep.order.size(); ++next) {
      const int node = sweep.order[next];
      for (const int other : neighbours(node)) reach(other, sweep.distance[std::size_t(node)] + 1);
    }
  };

  for (const int unknown : front) reach(unknown / per_node_, 0);
  visit_neighbours();
  for (int node = 0; node < nodes_; ++node) {  // pieces that are not connected to the front
    reach(node, 0);
    visit_neighbours();
  }
  return sweep;
}

std::vector<int> sweep_order(const SparsityPattern& pattern, std::span<const int> front) {
  const int per_node = pattern.unknowns_per_node();
  const auto order = NodeGraph(pattern, per_node).sweep_from(front).order;
  std::vector<int> place(std::size_t(pattern.unknowns()));
  for (std::size_t p = 0; p < order.size(); ++p) {
    for (int d = 0; d < per_node; ++d)
      place[std::size_t(order[p] * per_node + d)] = static_cast<int>(p) * per_node + d;
  }
  return place;
}

std::vector<int> reversed_order(int unknowns) {
  std::vector<int> place(std::size_t(unknowns), 0);
  for (int u = 0; u < unknowns; ++u) place[std::size_t(u)] = unknowns - 1 - u;
  return place;
}

}  // namespace dccast::linalg
