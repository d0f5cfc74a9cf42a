#pragma once

#include <vector>

namespace dccast::mesh {

/// Widths of `cells` cells [m] in a geometric progression, the first of width `first` [m] and with
/// the sum `length` [m].
std::vector<double> graded_cells(double length, int cells, double first);

/// Positions of the ends of cells from zero to `length` [m]; the last one is exactly `length`.
/// @param widths  [m]
/// @param length  [m]
std::vector<double> ends_of_cells(const std::vector<double>& widths, double length);

/// Divides every interval between positions [m] into `refinement` equal ones; returns all positions
/// [m].
std::vector<double> refined(const std::vector<double>& at, int refinement);

}  // namespace dccast::mesh
