#pragma once

#include <array>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/base.hpp"

namespace dccast::testing {

/// A plan of rectangles between lines of a grid, without those that `is_metal` leaves out. Sides of
/// the outline on the axes are middle planes; the others are side_x or side_y by their direction.
/// @param x, y      [m] of the lines, from zero
/// @param is_metal  by the middle of a cell [m]
inline mesh::Base<3> draw_plan(const std::vector<double>& x, const std::vector<double>& y,
                               const std::function<bool(double, double)>& is_metal) {
  const int columns = static_cast<int>(x.size()) - 1, layers = static_cast<int>(y.size()) - 1;
  const auto is_cell = [&](int i, int j) {
    if (i < 0 || j < 0 || i >= columns || j >= layers) return false;
    const std::size_t a = std::size_t(i), b = std::size_t(j);
    return is_metal(0.5 * (x[a] + x[a + 1]), 0.5 * (y[b] + y[b + 1]));
  };

  mesh::Base<3> plan;
  plan.walls = {{"symmetry_x", mesh::PatchKind::symmetry, {-1, 0, 0}, {}},
                {"symmetry_y", mesh::PatchKind::symmetry, {0, -1, 0}, {}},
                {"side_x", mesh::PatchKind::side, {1, 0, 0}, {}},
                {"side_y", mesh::PatchKind::side, {0, 1, 0}, {}}};
  std::map<std::pair<int, int>, int> number;
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < layers; ++j) {
      if (!is_cell(i, j)) continue;
      const int cell = plan.cells();
      for (const auto& [a, b] : {std::pair{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}) {
        const auto [found, is_new] = number.try_emplace({a, b}, plan.nodes());
        if (is_new) plan.node.insert(plan.node.end(), {x[std::size_t(a)], y[std::size_t(b)]});
        plan.cell_node.push_back(found->second);
      }
      if (!is_cell(i, j - 1)) plan.walls[1].pieces.push_back({cell, 0});
      if (!is_cell(i + 1, j)) plan.walls[2].pieces.push_back({cell, 1});
      if (!is_cell(i, j + 1)) plan.walls[3].pieces.push_back({cell, 2});
      if (!is_cell(i - 1, j)) plan.walls[0].pieces.push_back({cell, 3});
    }
  }
  return plan;
}

/// A plan in the format MSH 2.2. Walls of one face, as side_y and side_y_2, are one group.
inline std::string gmsh_text(const mesh::Base<3>& plan) {
  const auto group_of = [](const std::string& wall) {
    const std::size_t number = wall.find_last_of('_');
    return wall.find_first_of("0123456789", number) == std::string::npos ? wall
                                                                         : wall.substr(0, number);
  };
  std::vector<std::string> groups;
  std::string lines;
  std::size_t tag = 0;
  for (const auto& wall : plan.walls) {
    if (groups.empty() || groups.back() != group_of(wall.name))
      groups.push_back(group_of(wall.name));
    for (const auto& piece : wall.pieces) {
      const int* corner = &plan.cell_node[std::size_t(4 * piece.cell)];
      lines += std::to_string(++tag) + " 1 2 " + std::to_string(groups.size()) + " 1 " +
               std::to_string(corner[piece.side] + 1) + " " +
               std::to_string(corner[(piece.side + 1) % 4] + 1) + "\n";
    }
  }

  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n" +
                     std::to_string(groups.size()) + "\n";
  for (std::size_t g = 0; g < groups.size(); ++g)
    text += "1 " + std::to_string(g + 1) + " \"" + groups[g] + "\"\n";
  text += "$EndPhysicalNames\n$Nodes\n" + std::to_string(plan.nodes()) + "\n";

  for (std::size_t n = 0; n < std::size_t(plan.nodes()); ++n) {
    std::array<char, 80> line{};
    std::snprintf(line.data(), line.size(), "%zu %.17g %.17g 0\n", n + 1, plan.node[2 * n],
                  plan.node[2 * n + 1]);
    text += line.data();
  }
  text += "$EndNodes\n$Elements\n" + std::to_string(tag + std::size_t(plan.cells())) + "\n" + lines;
  for (std::size_t cell = 0; cell < std::size_t(plan.cells()); ++cell) {
    text += std::to_string(++tag) + " 3 2 0 1";
    for (std::size_t k = 0; k < 4; ++k)
      text += " " + std::to_string(plan.cell_node[4 * cell + k] + 1);
    text += "\n";
  }
  return text + "$EndElements\n";
}

inline void write_text(const std::string& text, const std::filesystem::path& path) {
  std::ofstream(path) << text;
}

}  // namespace dccast::testing
