#include "core/mesh/plan_transfer.hpp"

#include <algorithm>
#include <cmath>

#include "core/mesh/base.hpp"

namespace dccast::mesh {

namespace {

/// Area of a cell of a plan [m2].
double area_of(const Base<3>& plan, std::size_t cell) {
  const auto corner = [&](std::size_t k) {
    return &plan.node[2 * std::size_t(plan.cell_node[4 * cell + k % 4])];
  };
  double twice = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const double *a = corner(k), *b = corner(k + 1);
    twice += a[0] * b[1] - b[0] * a[1];
  }
  return 0.5 * twice;
}

/// Where a node of the heat's plan lies in the cells of the mechanics' plan along one direction.
struct Along {
  std::size_t cell;
  double share;  ///< [1] of the way through the cell
};

Along along(std::size_t heat_node, std::size_t cells, std::size_t parts) {
  const std::size_t cell = std::min(heat_node / parts, cells - 1);
  return {cell, static_cast<double>(heat_node - cell * parts) / static_cast<double>(parts)};
}

}  // namespace

PlanTransfer::PlanTransfer(const SectionSpec& spec) {
  const auto columns = std::size_t(spec.columns) * std::size_t(spec.refinement);
  const auto layers = std::size_t(spec.layers) * std::size_t(spec.refinement);
  const auto per_column = std::size_t(spec.heat_cells.per_column);
  const auto per_layer = std::size_t(spec.heat_cells.per_layer);
  if (per_column * per_layer == 1) return;

  const Base<3> heat = base_of<3>(spec, Plan::heat);
  const std::size_t heat_layers = layers * per_layer;

  // Nodes and cells of a plan are numbered along y first.
  for (std::size_t i = 0; i <= columns; ++i)
    for (std::size_t j = 0; j <= layers; ++j)
      nodes_.push_back(i * per_column * (heat_layers + 1) + j * per_layer);

  parts_.resize(columns * layers);
  for (std::size_t cell = 0; cell < columns * per_column * heat_layers; ++cell) {
    const std::size_t i = cell / heat_layers / per_column, j = cell % heat_layers / per_layer;
    around_.push_back(i * layers + j);
    parts_[around_.back()].push_back({cell, area_of(heat, cell)});
  }
  for (auto& parts : parts_) {
    double whole = 0.0;
    for (const Part& part : parts) whole += part.share;
    for (Part& part : parts) part.share /= whole;
  }

  for (std::size_t i = 0; i <= columns * per_column; ++i) {
    for (std::size_t j = 0; j <= heat_layers; ++j) {
      const auto [column, x] = along(i, columns, per_column);
      const auto [layer, y] = along(j, layers, per_layer);
      const std::size_t corner = column * (layers + 1) + layer;
      places_.push_back({{corner, corner + layers + 1, corner + layers + 2, corner + 1},
                         {(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y}});
    }
  }
}

std::vector<double> PlanTransfer::at_mechanics_nodes(std::span<const double> field) const {
  if (same_mesh()) return {field.begin(), field.end()};

  std::vector<double> values;
  for (std::size_t first = 0; first < field.size(); first += places_.size())
    for (const std::size_t node : nodes_) values.push_back(field[first + node]);
  return values;
}

std::vector<double> PlanTransfer::at_heat_nodes(std::vector<double> field,
                                                std::size_t components) const {
  if (same_mesh()) return field;

  const std::size_t per_row = nodes_.size() * components;
  std::vector<double> values;
  values.reserve(field.size() / nodes_.size() * places_.size());
  for (std::size_t first = 0; first < field.size(); first += per_row) {
    for (const Place& place : places_) {
      for (std::size_t c = 0; c < components; ++c) {
        double value = 0.0;
        for (std::size_t k = 0; k < 4; ++k)
          value += place.weight[k] * field[first + place.node[k] * components + c];
        values.push_back(value);
      }
    }
  }
  return values;
}

}  // namespace dccast::mesh
