#include "client/text/terminal.hpp"

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include <sys/ioctl.h>
#include <unistd.h>

namespace dccast::client {
namespace {

constexpr int fewest_columns = 20;

int columns_of(int descriptor) {
  if (const char* const columns = std::getenv("COLUMNS"))
    if (const int count = std::atoi(columns); count >= fewest_columns) return count;
  winsize size{};
  if (ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col >= fewest_columns)
    return size.ws_col;
  return 80;
}

bool continuation(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0) == 0x80;
}

}  // namespace

Terminal terminal_of(int descriptor) {
  Terminal terminal;
  const char* const kind = std::getenv("TERM");
  terminal.interactive =
      isatty(descriptor) == 1 && !(kind != nullptr && std::string_view(kind) == "dumb");
  const char* const no_colour = std::getenv("NO_COLOR");
  terminal.colour = terminal.interactive && (no_colour == nullptr || *no_colour == '\0');
  terminal.columns = columns_of(descriptor);
  terminal.descriptor = descriptor;
  return terminal;
}

int columns_now(const Terminal& terminal) {
  return terminal.descriptor < 0 ? terminal.columns : columns_of(terminal.descriptor);
}

int display_width(const std::string& text) {
  int width = 0;
  for (const char byte : text) width += continuation(byte) ? 0 : 1;
  return width;
}

std::string cut_to(const std::string& text, int columns) {
  int width = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (continuation(text[i])) continue;
    if (width == columns) return text.substr(0, i);
    ++width;
  }
  return text;
}

std::string wrapped(const std::string& text, int columns, int first, int indent) {
  std::string lines;
  int column = first;
  for (std::size_t at = 0; at < text.size();) {
    std::size_t blank = std::min(text.find(' ', at), text.size());
    while (blank + 1 < text.size() && text[blank + 1] == '%')  // "13 %" stays together
      blank = std::min(text.find(' ', blank + 1), text.size());
    const std::string word = text.substr(at, blank - at);

    if (at > 0 && column + 1 + display_width(word) > columns) {
      lines += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (at > 0) {
      lines += " ";
      ++column;
    }

    lines += word;
    column += display_width(word);
    at = blank + 1;
  }
  return lines;
}

std::string bold(const std::string& text, const Terminal& terminal) {
  return terminal.colour ? "\033[1m" + text + "\033[0m" : text;
}

std::string red(const std::string& text, const Terminal& terminal) {
  return terminal.colour ? "\033[1;31m" + text + "\033[0m" : text;
}

}  // namespace dccast::client
