#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace dccast::client::render {

/// A small curve of braille characters, 2 x 4 dots a cell.
/// @param y        values, evenly spread over the width
/// @param columns  cells in a line, @param rows lines
/// @return         `rows` lines without line ends, the uppermost first
std::vector<std::string> braille_curve(const std::vector<double>& y, int columns, int rows);

/// One of several lines over each other.
struct BrailleLine {
  std::vector<double> x, y;  ///< as long as each other; x rises
};

struct BrailleCell {
  std::string text;                 ///< one character
  std::optional<std::size_t> line;  ///< the last one that runs through it; nothing: none does
};

struct BrailleChart {
  std::vector<std::vector<BrailleCell>> cells;  ///< by row, the uppermost first
  double low = 0.0, high = 0.0;                 ///< y of the lower and the upper edge
};

/// Lines over each other on common axes that include y = 0.
/// @param columns  cells in a row, 2 x 4 dots each, @param rows of cells
BrailleChart braille_chart(const std::vector<BrailleLine>& lines, int columns, int rows);

}  // namespace dccast::client::render
