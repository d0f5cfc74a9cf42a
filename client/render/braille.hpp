#pragma once

#include <string>
#include <vector>

namespace dccast::client::render {

/// A small curve of braille characters, 2 x 4 dots a cell.
/// @param y        values, evenly spread over the width
/// @param columns  cells in a line, @param rows lines
/// @return         `rows` lines without line ends, the uppermost first
std::vector<std::string> braille_curve(const std::vector<double>& y, int columns, int rows);

}  // namespace dccast::client::render
