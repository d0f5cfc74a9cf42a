#include "core/mesh/slab_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dccast::mesh {

namespace {

/// Sum of 1 + r + ... + r^(n-1) with r = exp(log_ratio); without cancellation where r is near one.
double geometric_sum(double log_ratio, int terms) {
  return log_ratio == 0.0 ? terms : std::expm1(terms * log_ratio) / std::expm1(log_ratio);
}

std::vector<double> running_sum(const std::vector<double>& widths, double length) {
  std::vector<double> at{0.0};
  for (double w : widths) at.push_back(at.back() + w);
  at.back() = length;  // free of the rounding of the sum: patches must close
  return at;
}

std::vector<double> refined(const std::vector<double>& at, int refinement) {
  std::vector<double> fine{at.front()};
  for (std::size_t i = 1; i < at.size(); ++i) {
    for (int k = 1; k < refinement; ++k) {
      fine.push_back(at[i - 1] + (at[i] - at[i - 1]) * k / refinement);
    }
    fine.push_back(at[i]);
  }
  return fine;
}

std::vector<double> column_positions(const SectionSpec& spec) {
  std::vector<double> widths = graded_cells(spec.half_width, spec.columns, spec.side_cell);
  std::reverse(widths.begin(), widths.end());
  return refined(running_sum(widths, spec.half_width), spec.refinement);
}

std::vector<double> initial_rows(const SectionSpec& spec) {
  return refined(running_sum(graded_cells(spec.initial_depth, spec.rows, spec.bottom_cell),
                             spec.initial_depth),
                 spec.refinement);
}

double growth_cell(const SectionSpec& spec, const std::vector<double>& y) {
  return spec.growth_cell ? *spec.growth_cell / spec.refinement : y.back() - y[y.size() - 2];
}

constexpr double divide_above = 1.5;  // growth cells

}  // namespace

std::vector<double> graded_cells(double length, int cells, double first) {
  // Monotone in the ratio, so bisection on its logarithm cannot miss.
  double low = -3.0, high = 3.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (first * geometric_sum(middle, cells) < length ? low : high) = middle;
  }
  const double log_ratio = 0.5 * (low + high);
  std::vector<double> widths;
  const double scale = length / geometric_sum(log_ratio, cells);
  for (int i = 0; i < cells; ++i) widths.push_back(scale * std::exp(log_ratio * i));
  return widths;
}

int rows_at(const SectionSpec& spec, double level) {
  const std::vector<double> y = initial_rows(spec);
  const double cell = growth_cell(spec, y);
  const double over = level - y[y.size() - 2];
  const int added = over > divide_above * cell
                        ? static_cast<int>(std::ceil((over - divide_above * cell) / cell - 1e-9))
                        : 0;
  return static_cast<int>(y.size()) - 1 + added;
}

SlabMesh::SlabMesh(const SectionSpec& spec)
    : kind_(spec.element), x_(column_positions(spec)), y_(initial_rows(spec)) {
  growth_cell_ = growth_cell(spec, y_);
  build();
}

void SlabMesh::build() {
  mesh_ = Mesh2D{};
  mesh_.nodes_per_element = kind_ == ElementKind::p1 ? 3 : 4;
  for (int row = 0; row <= rows(); ++row) place_row_of_nodes(row);
  for (int row = 0; row < rows(); ++row) add_row_of_cells(row);
  for (int column = 0; column < columns(); ++column) {
    const int element = kind_ == ElementKind::p1 ? 2 * column : column;
    mesh_.facets(Patch::bottom).push_back({{column, column + 1}, 2, element});
  }
  rebuild_top();
}

void SlabMesh::place_row_of_nodes(int row) {
  const std::size_t first = std::size_t(row) * x_.size();
  if (mesh_.node.size() < 2 * (first + x_.size())) mesh_.node.resize(2 * (first + x_.size()));
  for (std::size_t i = 0; i < x_.size(); ++i) {
    mesh_.node[2 * (first + i)] = x_[i];
    mesh_.node[2 * (first + i) + 1] = y_[std::size_t(row)];
  }
}

void SlabMesh::add_row_of_cells(int row) {
  const int per_cell = kind_ == ElementKind::p1 ? 2 : 1;
  const int first_element = mesh_.elements();
  for (int column = 0; column < columns(); ++column) {
    const int sw = row * nodes_per_row() + column;
    const int se = sw + 1, nw = sw + nodes_per_row(), ne = nw + 1;
    if (kind_ == ElementKind::p1) {
      for (int n : {sw, se, ne, sw, ne, nw}) mesh_.element_node.push_back(n);
    } else {
      for (int n : {sw, se, ne, nw}) mesh_.element_node.push_back(n);
    }
  }
  const int below = row * nodes_per_row(), above = below + nodes_per_row();
  // The left triangle of the first cell is its second, the right one of the last cell its first.
  mesh_.facets(Patch::symmetry).push_back({{above, below}, 2, first_element + per_cell - 1});
  mesh_.facets(Patch::side)
      .push_back({{below + columns(), above + columns()}, 2,
                  first_element + per_cell * (columns() - 1)});
}

void SlabMesh::rebuild_top() {
  auto& top = mesh_.facets(Patch::top);
  top.clear();
  const int per_cell = kind_ == ElementKind::p1 ? 2 : 1;
  const int first_node = rows() * nodes_per_row();
  const int first_element = per_cell * columns() * (rows() - 1);
  for (int column = columns() - 1; column >= 0; --column) {
    top.push_back({{first_node + column + 1, first_node + column}, 2,
                   first_element + per_cell * column + per_cell - 1});
  }
}

std::vector<double> SlabMesh::grow_to(double level) {
  if (level < y_.back()) throw std::logic_error("SlabMesh: the metal level cannot sink");
  std::vector<double> between;
  y_.back() = level;
  while (y_.back() - y_[y_.size() - 2] > divide_above * growth_cell_) {
    const double height = y_[y_.size() - 2] + growth_cell_;
    y_.back() = height;
    y_.push_back(level);
    between.push_back(height);
  }
  const int last_old_row = rows() - static_cast<int>(between.size());
  for (int row = last_old_row; row <= rows(); ++row) place_row_of_nodes(row);
  for (int row = last_old_row; row < rows(); ++row) add_row_of_cells(row);
  if (!between.empty()) rebuild_top();
  return between;
}

void SlabMesh::restore(const std::vector<double>& row_heights) {
  y_ = row_heights;
  build();
}

}  // namespace dccast::mesh
