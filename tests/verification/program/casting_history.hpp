#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "core/mesh/section_spec.hpp"

namespace dccast::verification {

/// One run of the start of a casting on any mesh and steps: what studies of its error are made of.
struct HistoryRequest {
  mesh::ElementKind element = mesh::ElementKind::q1_bending;
  std::string quality;                   ///< empty: the paper's size
  std::optional<int> columns, rows;      ///< of equal width and height
  std::optional<double> growth_cell;     ///< [m]
  int refinement = 1, divide_steps = 1;  ///< every cell, every step divided by so many
  double limit = 1e9;                    ///< [s] after which it is given up
  std::string file;                      ///< for time and curl as CSV; empty: none

  /// Adds the options of the command, all but its element.
  void add_to(CLI::App& command);
};

/// Runs it; prints nodes, steps, processor seconds and the curl at the end.
/// @return whether it reached its end
bool write_history(const HistoryRequest& request);

}  // namespace dccast::verification
