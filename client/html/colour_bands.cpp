#include "client/html/colour_bands.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/core.h>

#include "client/html/svg_chart.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

/// @param part  0 at a, 1 at b
Point between(const Point& a, const Point& b, double part) {
  return {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)};
}

using ValuedPoint = std::pair<Point, double>;

/// The part of a polygon where sign * (value - level) is not negative.
std::vector<ValuedPoint> cut(const std::vector<ValuedPoint>& polygon, double level, double sign) {
  std::vector<ValuedPoint> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto& [a, value_a] = polygon[i];
    const auto& [b, value_b] = polygon[(i + 1) % polygon.size()];
    const double above_a = sign * (value_a - level), above_b = sign * (value_b - level);
    if (above_a >= 0.0) kept.push_back(polygon[i]);
    if ((above_a > 0.0 && above_b < 0.0) || (above_a < 0.0 && above_b > 0.0)) {
      kept.push_back({between(a, b, above_a / (above_a - above_b)), level});
    }
  }
  return kept;
}

}  // namespace

std::vector<Segment> isotherm(const std::vector<Point>& node, const std::vector<double>& value,
                              const std::vector<std::array<int, 3>>& triangles, double level) {
  std::vector<Segment> segments;
  for (const auto& triangle : triangles) {
    Segment segment;
    int found = 0;
    for (int i = 0; i < 3; ++i) {
      const int a = triangle[static_cast<std::size_t>(i)],
                b = triangle[static_cast<std::size_t>((i + 1) % 3)];
      if ((value[a] < level) == (value[b] < level)) continue;
      segment[static_cast<std::size_t>(found++)] =
          between(node[a], node[b], (level - value[a]) / (value[b] - value[a]));
    }
    if (found == 2) segments.push_back(segment);
  }
  return segments;
}

std::string ColourBands::colour(int band) const {
  static constexpr double stops[6][3] = {{43, 58, 125},  {73, 97, 184},  {143, 92, 177},
                                         {214, 89, 120}, {243, 142, 79}, {252, 216, 106}};
  const double place = (band + 0.5) / count * 5.0;
  const int from = static_cast<int>(place);
  const auto part = [&](int c) {
    return std::lround(stops[from][c] + (place - from) * (stops[from + 1][c] - stops[from][c]));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", part(0), part(1), part(2));
}

int ColourBands::band_of(double value) const {
  return static_cast<int>(
      std::clamp(std::floor(count * (value - low) / (high - low)), 0.0, count - 1.0));
}

std::vector<BandPiece> band_pieces(const std::array<Point, 3>& corner,
                                   const std::array<double, 3>& value, const ColourBands& bands) {
  const auto [least, greatest] = std::minmax_element(value.begin(), value.end());
  const int first = bands.band_of(*least), last = bands.band_of(*greatest);
  std::vector<BandPiece> pieces;
  for (int band = first; band <= last; ++band) {
    std::vector<ValuedPoint> part;
    for (std::size_t i = 0; i < 3; ++i) part.push_back({corner[i], value[i]});
    // Values outside the range belong to the outermost bands.
    if (band > first) part = cut(part, bands.level(band), 1.0);
    if (band < last) part = cut(part, bands.level(band + 1), -1.0);
    if (part.size() < 3) continue;
    BandPiece piece{band, {}};
    for (const auto& [point, ignored] : part) piece.outline.push_back(point);
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

std::string colour_bar(const ColourBands& bands, const std::string& unit, double x, double top,
                       double height) {
  std::string svg;
  for (int band = 0; band < bands.count; ++band)
    svg += fmt::format("<rect x='{:.1f}' y='{:.1f}' width='12' height='{:.1f}' fill='{}'/>", x,
                       top + height * (bands.count - 1 - band) / bands.count,
                       height / bands.count + 0.5, bands.colour(band));
  const auto ticks = round_ticks(bands.low, bands.high, 5);
  const int decimals =
      std::max(0, static_cast<int>(std::ceil(-std::log10(ticks[1] - ticks[0]) - 1e-9)));
  for (const double level : ticks)
    if (level >= bands.low - 1e-9 && level <= bands.high + 1e-9)
      svg += svg_text("class='tick'", x + 17,
                      top + height * (bands.high - level) / (bands.high - bands.low) + 4,
                      fixed(level, decimals));
  return svg + svg_text("class='label'", x, top - 8, unit);
}

}  // namespace dccast::client::render
