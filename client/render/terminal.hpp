#pragma once

#include <string>

namespace dccast::client::render {

/// What an output stream can show.
struct Terminal {
  bool interactive = false;  ///< a terminal that understands a carriage return
  bool colour = false;       ///< interactive and NO_COLOR is not set
  int columns = 80;          ///< COLUMNS, else what the terminal says
  int descriptor = -1;       ///< of the stream; -1: no window is behind it
};

/// Of a file descriptor (1: standard output, 2: standard error).
Terminal terminal_of(int descriptor);

/// Columns that the terminal has now: its window may have changed.
int columns_now(const Terminal& terminal);

/// Columns that a UTF-8 text takes, counted in code points; our texts hold no wide characters.
int display_width(const std::string& text);

/// The text cut to this many columns.
std::string cut_to(const std::string& text, int columns);

/// The text in bold, if the terminal shows colour.
std::string bold(const std::string& text, const Terminal& terminal);

}  // namespace dccast::client::render
