#pragma once

#include <optional>

#include "tests/verification/program/table.hpp"

namespace dccast::verification {

struct TableOptions {
  bool full = false;     ///< tables 4 to 6 at the paper's time step
  double limit = 600.0;  ///< [s] table 11: processor time after which an algorithm is given up
  bool slab = false;     ///< table 11: in three dimensions
};

/// A table of the paper beside ours; nothing for a number that is none of 1 to 8 and 11.
std::optional<Table> paper_table(int number, const TableOptions& options);

/// Whether this program was built with what castings need: case files and their translation.
bool has_casting_table();
/// Table 11. @throws std::logic_error without castings
Table casting_table(const TableOptions& options);
/// The element families under refinement: which one gives the smaller error for the same seconds,
/// and whether both tend to one curl, their intervals of uncertainty overlapping.
struct ElementComparison {
  Table table;
  bool same_limit = false;
};
/// @throws std::logic_error without castings
ElementComparison compare_elements(const TableOptions& options);

}  // namespace dccast::verification
