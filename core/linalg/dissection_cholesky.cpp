#include "core/linalg/dissection_cholesky.hpp"

#include <algorithm>

namespace dccast::linalg {

namespace {

constexpr int tile_entries = tile_size * tile_size;

/// Rows of tiles that hold a number of unknowns.
int tile_rows(std::size_t unknowns) {
  return static_cast<int>((unknowns + tile_size - 1) / tile_size);
}

/// Tiles in a lower triangle.
std::size_t triangle(int rows) {
  return std::size_t(rows) * std::size_t(rows + 1) / 2;
}

/// Index of an entry: the offset of its row plus the offset of its column.
/// @param first_tile  first tile of the row
int row_offset(std::size_t first_tile, int row) {
  return static_cast<int>(first_tile) * tile_entries + row % tile_size;
}

int column_offset(int column) {
  return column / tile_size * tile_entries + column % tile_size * tile_size;
}

}  // namespace

void DissectionCholesky::analyze(const SparsityPattern& pattern, const DissectionTree& tree) {
  per_node_ = tree.unknowns_per_node;
  place_fronts(tree);
  place_updates(tree);
  place_boundaries(tree);
  place_entries(pattern, tree);
}

void DissectionCholesky::place_fronts(const DissectionTree& tree) {
  part_.assign(tree.fronts.size() + 1, {});
  std::size_t tiles = 0, nodes = 0, most_boundary = 0;
  int rows = 0, most_pivots = 0, most_rows = 0;
  for (std::size_t f = 0; f < tree.fronts.size(); ++f) {
    const auto& front = tree.fronts[f];
    Part& part = part_[f];
    part.unknowns = (front.end - front.first) * per_node_;
    part.pivots = tile_rows(std::size_t(part.unknowns));
    part.boundary = tile_rows(front.boundary.size() * std::size_t(per_node_));
    part.children = front.children;

    part.first_row = rows;
    part.panel = tiles;
    part.first_node = nodes;

    rows += part.pivots;
    tiles += Front::row_start(part.pivots + part.boundary, part.pivots);
    nodes += front.boundary.size();
    most_rows = std::max(most_rows, part.boundary);
    most_pivots = std::max(most_pivots, part.pivots);
    most_boundary = std::max(most_boundary, front.boundary.size());
  }
  part_.back().panel = tiles;
  part_.back().first_node = nodes;

  panel_.reserve(tiles);
  inverse_.resize(std::size_t(rows));
  right_.assign(std::size_t(rows), TileRow{});
  rest_.assign(std::size_t(std::max(1, most_rows)), TileRow{});  // a single front has no boundary
  sums_.assign(std::size_t(most_pivots), Tile{});
  for (auto* offsets : {&offset_.child, &offset_.panel, &offset_.update})
    offsets->resize(most_boundary);
}

/// Updates wait for their parent on a stack. Those of the children lie on the other one, so that
/// the parent's can be formed from them.
void DissectionCholesky::place_updates(const DissectionTree& tree) {
  std::array<std::size_t, 2> top{}, most{};
  for (std::size_t f = 0; f < tree.fronts.size(); ++f) {
    Part& part = part_[f];
    part.stack = std::size_t(tree.fronts[f].depth) % 2;
    if (!part.children.empty())
      top[1 - part.stack] = part_[std::size_t(part.children.front())].update;
    part.update = top[part.stack];
    top[part.stack] += triangle(part.boundary);
    most[part.stack] = std::max(most[part.stack], top[part.stack]);
  }
  for (std::size_t s = 0; s < most.size(); ++s)
    update_[s].reserve(std::max<std::size_t>(1, most[s]));
}

void DissectionCholesky::place_boundaries(const DissectionTree& tree) {
  const std::size_t nodes = tree.place.size();
  std::vector<int> row_at(nodes);  // (place) of the first unknown
  for (std::size_t f = 0; f < tree.fronts.size(); ++f) {
    const auto& front = tree.fronts[f];
    for (int p = front.first; p < front.end; ++p)
      row_at[std::size_t(p)] = part_[f].first_row * tile_size + (p - front.first) * per_node_;
  }

  position_.resize(nodes * std::size_t(per_node_));
  for (std::size_t u = 0; u < position_.size(); ++u) {
    const std::size_t node = u / std::size_t(per_node_);
    position_[u] = row_at[std::size_t(tree.place[node])] + static_cast<int>(u) % per_node_;
  }

  right_row_.resize(part_.back().first_node);
  in_parent_.resize(right_row_.size());
  for (std::size_t f = 0; f < tree.fronts.size(); ++f) {
    std::size_t next = part_[f].first_node;
    for (const int p : tree.fronts[f].boundary) right_row_[next++] = row_at[std::size_t(p)];
    for (const int child : part_[f].children) place_in_parent(tree, std::size_t(child), f);
  }
}

void DissectionCholesky::place_in_parent(const DissectionTree& tree, std::size_t child,
                                         std::size_t parent) {
  const auto& front = tree.fronts[parent];
  std::size_t next = part_[child].first_node, parent_node = 0;
  for (const int p : tree.fronts[child].boundary) {
    if (p < front.end) {
      in_parent_[next++] = (p - front.first) * per_node_;
      continue;
    }
    while (front.boundary[parent_node] < p) ++parent_node;
    in_parent_[next++] =
        part_[parent].pivots * tile_size + static_cast<int>(parent_node) * per_node_;
  }
}

/// Assigns each entry of the matrix to the front that is the first to eliminate one of its two
/// unknowns.
void DissectionCholesky::place_entries(const SparsityPattern& pattern, const DissectionTree& tree) {
  std::vector<int> front_at(tree.place.size());  // (place)
  for (std::size_t f = 0; f < tree.fronts.size(); ++f) {
    const auto& front = tree.fronts[f];
    std::fill(front_at.begin() + front.first, front_at.begin() + front.end, static_cast<int>(f));
  }

  const auto for_each_entry = [&](const auto& use) {
    const auto& start = pattern.column_start();
    for (std::size_t c = 0; c + 1 < start.size(); ++c) {
      for (int k = start[c]; k < start[c + 1]; ++k) {
        const auto column_place = tree.place[c / std::size_t(per_node_)];
        const std::size_t r = std::size_t(pattern.row()[std::size_t(k)]);
        const auto row_place = tree.place[r / std::size_t(per_node_)];
        const std::size_t front =
            std::size_t(front_at[std::size_t(std::min(column_place, row_place))]);
        use(k, front, position_[c], position_[r], std::max(column_place, row_place));
      }
    }
  };

  // Count the entries of each front, then sort them by front.
  for_each_entry([&](int, std::size_t f, int, int, int) { ++part_[f + 1].first_entry; });
  for (std::size_t f = 1; f < part_.size(); ++f) part_[f].first_entry += part_[f - 1].first_entry;

  source_.resize(pattern.entries());
  target_.resize(pattern.entries());
  std::vector<std::size_t> next;
  for (const Part& part : part_) next.push_back(part.first_entry);
  for_each_entry([&](int k, std::size_t f, int a, int b, int later) {
    const Part& part = part_[f];
    const auto& front = tree.fronts[f];
    const int column = std::min(a, b) - part.first_row * tile_size;
    int row = std::max(a, b) - part.first_row * tile_size;
    if (later >= front.end) {  // the row is in the boundary
      const auto in_boundary =
          std::lower_bound(front.boundary.begin(), front.boundary.end(), later) -
          front.boundary.begin();
      row = part.pivots * tile_size + static_cast<int>(in_boundary) * per_node_ + std::max(a, b) -
            right_row_[part.first_node + std::size_t(in_boundary)];
    }

    const std::size_t entry = next[f]++;
    source_[entry] = k;
    target_[entry] =
        row_offset(Front::row_start(row / tile_size, part.pivots), row) + column_offset(column);
  });
}

Front DissectionCholesky::make_front(const Part& part) {
  return {panel_.get() + part.panel, update_[part.stack].get() + part.update,
          inverse_.data() + part.first_row, part.pivots, part.boundary};
}

/// Copies the entries of a front to its panel; the diagonal past its last unknown is one.
void DissectionCholesky::copy_matrix(std::span<const double> values, std::size_t number,
                                     const Front& front) {
  const Part& part = part_[number];
  std::fill(front.panel, panel_.get() + part_[number + 1].panel, Tile{});
  double* const panel = front.panel->entry;
  for (std::size_t i = part.first_entry; i < part_[number + 1].first_entry; ++i)
    panel[target_[i]] = values[std::size_t(source_[i])];
  for (int u = part.unknowns; u < part.pivots * tile_size; ++u)
    panel[row_offset(Front::row_start(u / tile_size, part.pivots), u) + column_offset(u)] = 1.0;
}

/// Adds the update of a child to the panel and the update of its parent (extend-add).
template <int PerNode>
void DissectionCholesky::add_columns(const Part& child, const Front& parent) {
  const std::size_t nodes = (&child + 1)->first_node - child.first_node;
  const int* const in_parent = &in_parent_[child.first_node];
  // Offsets of the child's rows in its own update, in the panel and in the update of the parent.
  for (std::size_t n = 0; n < nodes; ++n) {
    const int own = static_cast<int>(n) * PerNode, row = in_parent[n] / tile_size;
    offset_.child[n] = row_offset(triangle(own / tile_size), own);
    offset_.panel[n] = row_offset(Front::row_start(row, parent.pivots), in_parent[n]);
    offset_.update[n] = row_offset(triangle(std::max(0, row - parent.pivots)), in_parent[n]);
  }

  const double* const from = (update_[child.stack].get() + child.update)->entry;
  const int pivots = parent.pivots * tile_size;
  // A node that the parent eliminates goes to its panel, others to its update.
  for (std::size_t n = 0; n < nodes; ++n) {
    const bool eliminated = in_parent[n] < pivots;
    const int* const to_row = eliminated ? offset_.panel.data() : offset_.update.data();
    for (int d = 0; d < PerNode; ++d) {
      const double* const column = from + column_offset(static_cast<int>(n) * PerNode + d);
      double* const to = eliminated
                             ? parent.panel->entry + column_offset(in_parent[n] + d)
                             : parent.update->entry + column_offset(in_parent[n] - pivots + d);

      for (std::size_t m = n; m < nodes; ++m) {
        for (int e = 0; e < PerNode; ++e) to[to_row[m] + e] += column[offset_.child[m] + e];
      }
    }
  }
}

void DissectionCholesky::add_child(const Part& child, const Front& parent) {
  if ((&child + 1)->first_node == child.first_node) return;
  per_node_ == 1 ? add_columns<1>(child, parent) : add_columns<2>(child, parent);
}

bool DissectionCholesky::factorize(std::span<const double> values) {
  for (std::size_t f = 0; f + 1 < part_.size(); ++f) {
    const Front front = make_front(part_[f]);
    copy_matrix(values, f, front);
    std::fill(front.update, front.update + triangle(front.boundary), Tile{});
    for (const int child : part_[f].children) add_child(part_[std::size_t(child)], front);

    if (!kernels_->factorize_front(front)) return false;
  }
  return true;
}

/// Copies the solution on the boundary of a front to `rest_`.
void DissectionCholesky::gather(std::size_t part) {
  double* const rest = rest_.data()->entry;
  const double* const right = right_.data()->entry;
  const std::size_t per_node = std::size_t(per_node_), nodes = boundary_nodes(part);
  for (std::size_t n = 0; n < nodes; ++n) {
    const std::size_t row = std::size_t(right_row_[part_[part].first_node + n]);
    for (std::size_t d = 0; d < per_node; ++d) rest[n * per_node + d] = right[row + d];
  }

  const std::size_t end = std::size_t(part_[part].boundary) * tile_size;
  for (std::size_t i = nodes * per_node; i < end; ++i) rest[i] = 0.0;
}

/// Subtracts the products of the pivots of a front, in `rest_`, from the right-hand side.
void DissectionCholesky::scatter(std::size_t part) {
  const double* const rest = rest_.data()->entry;
  double* const right = right_.data()->entry;
  const std::size_t per_node = std::size_t(per_node_), nodes = boundary_nodes(part);
  for (std::size_t n = 0; n < nodes; ++n) {
    const std::size_t row = std::size_t(right_row_[part_[part].first_node + n]);
    for (std::size_t d = 0; d < per_node; ++d) right[row + d] -= rest[n * per_node + d];
  }
}

void DissectionCholesky::solve(std::span<const double> b, std::span<double> x) {
  std::fill(right_.begin(), right_.end(), TileRow{});
  double* const right = right_.data()->entry;
  for (std::size_t u = 0; u < position_.size(); ++u) right[position_[u]] = b[u];

  const std::size_t parts = part_.size() - 1;
  // L y = b from the leaves up: each front eliminates its pivots and updates its boundary.
  for (std::size_t f = 0; f < parts; ++f) {
    kernels_->forward_front(make_front(part_[f]), &right_[std::size_t(part_[f].first_row)],
                            rest_.data());
    scatter(f);
  }

  // L' x = y from the root down: the solution on the boundary of a front is known before its
  // pivots.
  for (std::size_t f = parts; f-- > 0;) {
    gather(f);
    kernels_->backward_front(make_front(part_[f]), &right_[std::size_t(part_[f].first_row)],
                             rest_.data(), sums_.data());
  }

  for (std::size_t u = 0; u < position_.size(); ++u) x[u] = right[position_[u]];
}

double DissectionCholesky::factor_entries() const {
  return static_cast<double>(tile_entries) *
         static_cast<double>(part_.empty() ? 0 : part_.back().panel);
}

std::size_t DissectionCholesky::memory_bytes() const {
  return panel_.bytes() + update_[0].bytes() + update_[1].bytes() +
         (inverse_.size() + right_.size() + rest_.size()) * sizeof(TileRow) +
         sums_.size() * sizeof(Tile) + part_.size() * sizeof(Part) +
         (source_.size() + target_.size() + position_.size() + right_row_.size() +
          in_parent_.size() + 3 * offset_.child.size()) *
             sizeof(int);
}

}  // namespace dccast::linalg
