#include "client/text/braille.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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

/// Value of a line at x; not a number outside of it.
double value_at(const BrailleLine& line, double x) {
  if (line.x.empty() || x < line.x.front() || x > line.x.back()) return NAN;
  const auto right =
      static_cast<std::size_t>(std::lower_bound(line.x.begin(), line.x.end(), x) - line.x.begin());
  if (right == 0) return line.y.front();
  const double share = (x - line.x[right - 1]) / (line.x[right] - line.x[right - 1]);
  return line.y[right - 1] + share * (line.y[right] - line.y[right - 1]);
}

/// Draws a curve in dots, and joins steep pieces, so that a jump is a line and not two dots.
/// @param value  at a share of the width; nothing is drawn where it is no finite number
/// @param set    called with row and column of a cell and the bit of a dot in it
template <class Value, class Set>
void draw(const Value& value, std::pair<double, double> range, int columns, int rows,
          const Set& set) {
  const double span = std::max(range.second - range.first, 1e-12);
  const int dots = 4 * rows;
  int previous = -1;
  for (int x = 0; x < 2 * columns; ++x) {
    const double y = value(static_cast<double>(x) / std::max(1, 2 * columns - 1));
    if (!std::isfinite(y)) {
      previous = -1;
      continue;
    }
    const int level =
        dots - 1 - static_cast<int>(std::lround((y - range.first) / span * (dots - 1)));
    const int from =
        previous < 0 ? level : std::min(level, previous < level ? previous + 1 : previous);
    const int to = previous < 0 ? level : std::max(level, previous > level ? previous - 1 : level);
    for (int d = std::min(from, level); d <= std::max(to, level); ++d)
      set(d / 4, x / 2, dot(x % 2, d % 4));
    previous = level;
  }
}

}  // namespace

std::vector<std::string> braille_curve(const std::vector<double>& y, int columns, int rows) {
  std::vector<std::vector<unsigned>> cells(rows, std::vector<unsigned>(columns, 0));
  if (!y.empty()) {
    const auto [low, high] = std::minmax_element(y.begin(), y.end());
    draw([&](double fraction) { return sample(y, fraction); }, {*low, *high}, columns, rows,
         [&](int row, int column, unsigned bit) { cells[row][column] |= bit; });
  }
  std::vector<std::string> lines;
  for (const auto& row : cells) {
    lines.emplace_back();
    for (const unsigned cell : row) lines.back() += braille(cell);
  }
  return lines;
}

BrailleChart braille_chart(const std::vector<BrailleLine>& lines, int columns, int rows) {
  BrailleChart chart;
  double begin = INFINITY, end = -INFINITY;
  for (const BrailleLine& line : lines) {
    if (line.x.empty()) continue;
    begin = std::min(begin, line.x.front());
    end = std::max(end, line.x.back());
    for (const double y : line.y) {
      chart.low = std::min(chart.low, y);
      chart.high = std::max(chart.high, y);
    }
  }
  std::vector<std::vector<unsigned>> dots(rows, std::vector<unsigned>(columns, 0));
  chart.cells.assign(rows, std::vector<BrailleCell>(columns));
  for (std::size_t i = 0; i < lines.size(); ++i)
    draw([&](double share) { return value_at(lines[i], begin + share * (end - begin)); },
         {chart.low, chart.high}, columns, rows,
         [&](int row, int column, unsigned bit) {
           dots[row][column] |= bit;
           chart.cells[row][column].line = i;
         });
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      chart.cells[row][column].text = braille(dots[row][column]);
  return chart;
}

}  // namespace dccast::client::render
