#pragma once

#include <string>
#include <vector>

#include "client/study.hpp"

namespace dccast::client::render {

/// A study as a text table: a row a level with the curl at the end; then observed order, limit and
/// uncertainty at the end, and the largest uncertainty of the whole history with its time.
std::string study_table(const Study& study);

/// The sentence below a table whose figures are marked with "!"; empty when all levels are valid.
std::string validity_note(const Study& study);

/// Monitors of the levels that succeeded.
std::vector<std::string> monitor_names(const Study& study);

/// The rows of that table in cells, for tables of other kinds: refinement, nodes, solver s and
/// state, then a cell for each monitor. limit_rows() is empty while nothing can be said.
std::vector<std::vector<std::string>> level_rows(const Study& study);
std::vector<std::vector<std::string>> limit_rows(const Study& study);

}  // namespace dccast::client::render
