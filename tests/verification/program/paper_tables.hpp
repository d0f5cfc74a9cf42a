#pragma once

#include <optional>

#include "tests/verification/program/table.hpp"

namespace dccast::verification {

struct TableOptions {
  bool full = false;     ///< tables 4 to 6 at the paper's time step
  double limit = 600.0;  ///< [s] table 11: processor time after which an algorithm is given up
};

/// A table of the paper beside ours; nothing for a number that is none of 1 to 8 and 11.
std::optional<Table> paper_table(int number, const TableOptions& options);

/// Whether this program was built with what table 11 needs: case files and their translation.
bool has_casting_table();
Table casting_table(const TableOptions& options);

}  // namespace dccast::verification
