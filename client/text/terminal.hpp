#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dccast::client {

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
/// The text in bold and red, if the terminal shows colour.
std::string red(const std::string& text, const Terminal& terminal);

}  // namespace dccast::client
