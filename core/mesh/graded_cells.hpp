#pragma once

#include <vector>

namespace dccast::mesh {

/// Widths of `cells` cells that sum to `length` [m], the first of width `first` [m] and each next
/// one larger (or smaller) by the same factor.
std::vector<double> graded_cells(double length, int cells, double first);

/// Positions of the ends of cells from zero to `length` [m], which the last one hits exactly.
std::vector<double> ends_of_cells(const std::vector<double>& widths, double length);

/// Divides every interval between positions [m] into `refinement` equal ones.
std::vector<double> refined(const std::vector<double>& at, int refinement);

}  // namespace dccast::mesh
