#include "client/render/braille.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::client::render {
namespace {

/// UTF-8 of U+2800 + dots.
std::string braille(unsigned dots) {
  const unsigned code = 0x2800u + dots;
  return {static_cast<char>(0xE0 | (code >> 12)), static_cast<char>(0x80 | ((code >> 6) & 0x3F)),
          static_cast<char>(0x80 | (code & 0x3F))};
}

/// Bit of the dot in column 0..1 and row 0..3 from above (Unicode, Braille Patterns).
unsigned dot(int column, int row) {
  static constexpr unsigned bits[2][4] = {{0x01, 0x02, 0x04, 0x40}, {0x08, 0x10, 0x20, 0x80}};
  return bits[column][row];
}

/// Value at a dot column, linear between the given ones.
double sample(const std::vector<double>& y, double fraction) {
  const double place = fraction * static_cast<double>(y.size() - 1);
  const auto left = std::min(static_cast<std::size_t>(place), y.size() - 1);
  const auto right = std::min(left + 1, y.size() - 1);
  return y[left] + (place - static_cast<double>(left)) * (y[right] - y[left]);
}

}  // namespace

std::vector<std::string> braille_curve(const std::vector<double>& y, int columns, int rows) {
  std::vector<std::vector<unsigned>> cells(rows, std::vector<unsigned>(columns, 0));
  if (!y.empty()) {
    const auto [low, high] = std::minmax_element(y.begin(), y.end());
    const double span = std::max(*high - *low, 1e-12);
    const int dots = 4 * rows;
    int previous = -1;
    for (int x = 0; x < 2 * columns; ++x) {
      const double value = sample(y, static_cast<double>(x) / std::max(1, 2 * columns - 1));
      const int level =
          dots - 1 - static_cast<int>(std::lround((value - *low) / span * (dots - 1)));
      // Joins steep pieces, so that a jump is a line and not two dots.
      const int from =
          previous < 0 ? level : std::min(level, previous < level ? previous + 1 : previous);
      const int to =
          previous < 0 ? level : std::max(level, previous > level ? previous - 1 : level);
      for (int d = std::min(from, level); d <= std::max(to, level); ++d)
        cells[d / 4][x / 2] |= dot(x % 2, d % 4);
      previous = level;
    }
  }
  std::vector<std::string> lines;
  for (const auto& row : cells) {
    lines.emplace_back();
    for (const unsigned cell : row) lines.back() += braille(cell);
  }
  return lines;
}

}  // namespace dccast::client::render
