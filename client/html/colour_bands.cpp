#include "client/html/colour_bands.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "client/html/svg_chart.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

Point crossing(const Point& a, const Point& b, double value_a, double value_b, double level) {
  const double part = (level - value_a) / (value_b - value_a);
  return {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)};
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
          crossing(node[a], node[b], value[a], value[b], level);
    }
    if (found == 2) segments.push_back(segment);
  }
  return segments;
}

namespace {

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
      const double part = above_a / (above_a - above_b);
      kept.push_back({{a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)}, level});
    }
  }
  return kept;
}

}  // namespace

std::string band_colour(double part) {
  static constexpr double stops[6][3] = {{43, 58, 125},  {73, 97, 184},  {143, 92, 177},
                                         {214, 89, 120}, {243, 142, 79}, {252, 216, 106}};
  const double place = std::clamp(part, 0.0, 1.0) * 5.0;
  const int from = std::min(static_cast<int>(place), 4);
  char text[16];
  int rgb[3];
  for (int c = 0; c < 3; ++c)
    rgb[c] = static_cast<int>(
        std::lround(stops[from][c] + (place - from) * (stops[from + 1][c] - stops[from][c])));
  std::snprintf(text, sizeof text, "#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
  return text;
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
    svg += "<rect x='" + fixed(x, 1) + "' y='" +
           fixed(top + height * (bands.count - 1 - band) / bands.count, 1) +
           "' width='12' height='" + fixed(height / bands.count + 0.5, 1) + "' fill='" +
           bands.colour(band) + "'/>";
  const auto ticks = round_ticks(bands.low, bands.high, 5);
  const int decimals =
      std::max(0, static_cast<int>(std::ceil(-std::log10(ticks[1] - ticks[0]) - 1e-9)));
  for (const double level : ticks)
    if (level >= bands.low - 1e-9 && level <= bands.high + 1e-9)
      svg += "<text class='tick' x='" + fixed(x + 17, 1) + "' y='" +
             fixed(top + height * (bands.high - level) / (bands.high - bands.low) + 4, 1) + "'>" +
             fixed(level, decimals) + "</text>";
  return svg + "<text class='label' x='" + fixed(x, 1) + "' y='" + fixed(top - 8, 1) + "'>" + unit +
         "</text>";
}

}  // namespace dccast::client::render
