#pragma once

#include <string>
#include <vector>

#include "client/study.hpp"

namespace dccast::client::render {

/// A study as a text table: one row per level with the curl at the end; then observed order, limit
/// and uncertainty at the end, and the largest uncertainty of the whole history with its time.
std::string study_table(const Study& study);

/// The note below a table whose figures are marked with "!"; empty if all levels are valid.
std::string validity_note(const Study& study);

/// Monitors of the levels that succeeded.
std::vector<std::string> monitor_names(const Study& study);

/// The cells of that table, for other kinds of tables: refinement, nodes, solver seconds and state,
/// then one cell per monitor. limit_rows() is empty while there is no result.
std::vector<std::vector<std::string>> level_rows(const Study& study);
std::vector<std::vector<std::string>> limit_rows(const Study& study);

}  // namespace dccast::client::render
