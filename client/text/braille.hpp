#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

/// Curves drawn with braille characters, of 2 x 4 dots each.
namespace dccast::client {

/// A small curve of braille characters with 2 x 4 dots per character.
/// @param y        values [any unit], evenly distributed over the width
/// @param columns  characters per line @param rows  number of lines
/// @return         `rows` lines without line ends, the uppermost first
std::vector<std::string> braille_curve(const std::vector<double>& y, int columns, int rows);

/// One of several lines in a common chart.
struct BrailleLine {
  std::vector<double> x, y;  ///< [any unit] of equal length; x ascending
};

/// A character of 2 by 4 dots, and its colour.
struct BrailleCell {
  std::string text;  ///< one character
  /// The last line that runs through the cell; empty if none does
  std::optional<std::size_t> line;
};

/// A chart of such characters.
struct BrailleChart {
  std::vector<std::vector<BrailleCell>> cells;  ///< by row, the uppermost first
  double low = 0.0, high = 0.0;                 ///< y at the lower and the upper edge [unit of y]
};

/// A piece of a line as braille_chart() draws it, for a legend. @param line  its index
std::string braille_sample(std::size_t line);

/// Draws several lines on common axes that include y = 0: the first whole, the others broken.
/// @param columns  characters per line, 2 x 4 dots each @param rows  number of lines
BrailleChart braille_chart(const std::vector<BrailleLine>& lines, int columns, int rows);

}  // namespace dccast::client
