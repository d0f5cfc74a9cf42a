#include "client/text/braille.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace dccast::client {
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

/// Value of a line at x; NaN outside its range.
double value_at(const BrailleLine& line, double x) {
  if (line.x.empty() || x < line.x.front() || x > line.x.back()) return NAN;
  const auto right =
      static_cast<std::size_t>(std::lower_bound(line.x.begin(), line.x.end(), x) - line.x.begin());
  if (right == 0) return line.y.front();
  const double share = (x - line.x[right - 1]) / (line.x[right] - line.x[right - 1]);
  return line.y[right - 1] + share * (line.y[right] - line.y[right - 1]);
}

/// Whether a line is drawn in a column of dots. The first line is solid, the others are dashed with
/// different patterns, so that they can be distinguished without colour.
bool pen_is_down(std::size_t line, int column) {
  struct Rhythm {
    int period, drawn;
  };
  static constexpr std::array<Rhythm, 4> rhythms{{{1, 1}, {6, 3}, {4, 1}, {10, 7}}};
  const Rhythm rhythm = rhythms[line % rhythms.size()];
  return column % rhythm.period < rhythm.drawn;
}

/// Draws lines within the limits of a chart. Steep pieces are joined, so that a jump is a line and
/// not two dots. Non-finite values are not drawn.
void draw(const std::vector<BrailleLine>& lines, double begin, double end, int columns, int rows,
          BrailleChart& chart) {
  const double span = std::max(chart.high - chart.low, 1e-12);
  const int dots = 4 * rows;
  std::vector<std::vector<unsigned>> drawn(rows, std::vector<unsigned>(columns, 0));
  chart.cells.assign(rows, std::vector<BrailleCell>(columns));

  for (std::size_t i = 0; i < lines.size(); ++i) {
    int previous = -1;
    for (int x = 0; x < 2 * columns; ++x) {
      const double share = static_cast<double>(x) / std::max(1, 2 * columns - 1);
      const double y = value_at(lines[i], begin + share * (end - begin));
      if (!std::isfinite(y)) {
        previous = -1;
        continue;
      }

      const int level =
          dots - 1 - static_cast<int>(std::lround((y - chart.low) / span * (dots - 1)));
      // Begins beside the previous dot, which is not drawn twice.
      const int from = previous < 0 ? level : previous + (level > previous) - (level < previous);
      previous = level;
      if (!pen_is_down(i, x)) continue;
      for (int d = std::min(from, level); d <= std::max(from, level); ++d) {
        drawn[d / 4][x / 2] |= dot(x % 2, d % 4);
        chart.cells[d / 4][x / 2].line = i;
      }
    }
  }

  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      chart.cells[row][column].text = braille(drawn[row][column]);
}

}  // namespace

std::string braille_sample(std::size_t line) {
  constexpr int columns = 10;
  std::string text;
  for (int x = 0; x < columns; x += 2)
    text += braille((pen_is_down(line, x) ? dot(0, 2) : 0u) |
                    (pen_is_down(line, x + 1) ? dot(1, 2) : 0u));
  return text;
}

std::vector<std::string> braille_curve(const std::vector<double>& y, int columns, int rows) {
  BrailleLine line{{}, y};
  for (std::size_t i = 0; i < y.size(); ++i) line.x.push_back(static_cast<double>(i));
  BrailleChart chart;
  if (!y.empty()) {
    const auto [low, high] = std::ranges::minmax(y);
    chart.low = low;
    chart.high = high;
  }
  draw({line}, 0.0, y.empty() ? 0.0 : line.x.back(), columns, rows, chart);
  std::vector<std::string> texts;
  for (const auto& row : chart.cells) {
    texts.emplace_back();
    for (const BrailleCell& cell : row) texts.back() += cell.text;
  }
  return texts;
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
  draw(lines, begin, end, columns, rows, chart);
  return chart;
}

}  // namespace dccast::client
