#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dccast::client::render {

/// Capabilities of an output stream.
struct Terminal {
  bool interactive = false;  ///< a terminal that understands a carriage return
  bool colour = false;       ///< interactive and NO_COLOR is not set
  int columns = 80;          ///< COLUMNS, else the width of the terminal
  int descriptor = -1;       ///< file descriptor; -1: the stream has no window
};

/// Capabilities of a file descriptor (1: standard output, 2: standard error).
Terminal terminal_of(int descriptor);

/// Present width of the terminal in columns: its window may have changed.
int columns_now(const Terminal& terminal);

/// Width of a UTF-8 text in columns, counted in code points; the texts of the program contain no
/// wide characters.
int display_width(const std::string& text);

/// The text cut to this many columns.
std::string cut_to(const std::string& text, int columns);

/// The text broken at blanks into lines of at most `columns`.
/// @param first   columns that stand before the text in its first line
/// @param indent  blanks before each further line
std::string wrapped(const std::string& text, int columns, int first = 0, int indent = 0);

/// The text in bold, if the terminal shows colour.
std::string bold(const std::string& text, const Terminal& terminal);

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

}  // namespace dccast::client::render
