#include "client/html/svg_chart.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

// Of the view box; the page scales it.
constexpr double width = 640, height = 320, left = 62, right = 16, top = 30, bottom = 46;
constexpr double legend_row = 17;
constexpr int line_colours = 6;

struct Axis {
  std::vector<double> ticks;
  double from, to;
  double low() const { return from; }
  double high() const { return to; }
};

std::vector<double> all_x(const Chart& chart) {
  std::vector<double> values;
  for (const ChartLine& line : chart.lines)
    for (const auto* part : {&line.x, &line.band.x})
      values.insert(values.end(), part->begin(), part->end());
  return values;
}

std::vector<double> all_y(const Chart& chart) {
  std::vector<double> values;
  for (const ChartLine& line : chart.lines)
    for (const auto* part : {&line.y, &line.band.low, &line.band.high})
      values.insert(values.end(), part->begin(), part->end());
  if (chart.wanted) values.insert(values.end(), {chart.wanted->low, chart.wanted->high});
  return values;
}

Axis axis_over(const std::vector<double>& values, bool with_zero, int count) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : values)
    if (std::isfinite(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  if (!(low <= high)) low = high = 0.0;
  if (with_zero) {
    low = std::min(low, 0.0);
    high = std::max(high, 0.0);
  }
  std::vector<double> ticks = round_ticks(low, high, count);
  if (with_zero && low < high && ticks.size() > 2) {
    // A little below zero, such as the edge of a band, must not cost a whole step of the axis.
    const double from = std::max(ticks.front(), low - 0.03 * (high - low));
    std::erase_if(ticks, [&](double tick) { return tick < from; });
    return {ticks, from, ticks.back()};
  }
  if (with_zero || !(low < high)) return {ticks, ticks.front(), ticks.back()};
  // Time and place end where the figures end; only values are rounded out.
  const double margin = 1e-9 * (high - low);
  std::erase_if(ticks, [&](double tick) { return tick < low - margin || tick > high + margin; });
  return {ticks, low, high};
}

double place_x(const Axis& axis, double x) {
  return left + (x - axis.low()) / (axis.high() - axis.low()) * (width - left - right);
}
double place_y(const Axis& axis, double y) {
  return height - bottom - (y - axis.low()) / (axis.high() - axis.low()) * (height - top - bottom);
}

std::string tick_text(double value, const Axis& axis) {
  const double step = axis.ticks[1] - axis.ticks[0];
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  return fixed(std::abs(value) < 1e-9 * step ? 0.0 : value, decimals);
}

std::string grid(const Axis& x, const Axis& y) {
  std::string svg;
  const std::string x0 = fixed(left, 1), x1 = fixed(width - right, 1);
  for (const double tick : y.ticks) {
    const std::string at = fixed(place_y(y, tick), 1);
    svg += "<line class='" + std::string(tick == 0.0 ? "zero" : "grid") + "' x1='" + x0 + "' x2='" +
           x1 + "' y1='" + at + "' y2='" + at + "'/><text class='tick' text-anchor='end' x='" +
           fixed(left - 6, 1) + "' y='" + fixed(place_y(y, tick) + 4, 1) + "'>" +
           tick_text(tick, y) + "</text>";
  }
  for (const double tick : x.ticks) {
    const std::string at = fixed(place_x(x, tick), 1);
    svg += "<line class='grid' x1='" + at + "' x2='" + at + "' y1='" + fixed(top, 1) + "' y2='" +
           fixed(height - bottom, 1) + "'/><text class='tick' text-anchor='middle' x='" + at +
           "' y='" + fixed(height - bottom + 17, 1) + "'>" + tick_text(tick, x) + "</text>";
  }
  return svg;
}

std::string path_of(const ChartLine& line, const Axis& x, const Axis& y) {
  std::string path;
  bool pen_down = false;
  for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i) {
    const bool drawable = std::isfinite(line.x[i]) && std::isfinite(line.y[i]);
    if (drawable)
      path += (pen_down ? "L" : "M") + fixed(place_x(x, line.x[i]), 2) + " " +
              fixed(place_y(y, line.y[i]), 2);
    pen_down = drawable;
  }
  return path;
}

/// Shaded from low to high, with the middle dashed. Below all lines: it must not hide them.
std::string band_of(const ChartLine& line, std::size_t number, const Axis& x, const Axis& y) {
  const ChartBand& band = line.band;
  if (band.x.empty()) return {};
  ChartLine outline{"", band.x, band.high};
  outline.x.insert(outline.x.end(), band.x.rbegin(), band.x.rend());
  outline.y.insert(outline.y.end(), band.low.rbegin(), band.low.rend());
  const std::string colour = "var(--line-" + std::to_string(number % line_colours) + ")";
  return "<path class='band' style='fill:" + colour + "' d='" + path_of(outline, x, y) +
         "Z'/><path class='middle' style='stroke:" + colour + "' d='" +
         path_of({"", band.x, band.middle}, x, y) + "'><title>" + html_escaped(line.name) +
         ", limit</title></path>";
}

/// Behind everything else, with its name at the top of the region.
std::string region_beyond(const Chart& chart, const Axis& x) {
  if (!chart.beyond_from) return {};
  const double from = std::clamp(place_x(x, *chart.beyond_from), left, width - right);
  return "<rect class='beyond' x='" + fixed(from, 1) + "' y='" + fixed(top, 1) + "' width='" +
         fixed(width - right - from, 1) + "' height='" + fixed(height - top - bottom, 1) +
         "'/><text class='tick' text-anchor='end' x='" + fixed(width - right - 4, 1) + "' y='" +
         fixed(height - bottom - 6, 1) + "'>" + html_escaped(chart.beyond_name) + "</text>";
}

/// Dashed edges where the region has them, and its name under the upper one.
std::string region_wanted(const Chart& chart, const Axis& y) {
  if (!chart.wanted) return {};
  const bool below = std::isfinite(chart.wanted->low), above = std::isfinite(chart.wanted->high);
  const double foot = below ? place_y(y, chart.wanted->low) : height - bottom,
               head = above ? place_y(y, chart.wanted->high) : top;
  const std::string x0 = fixed(left, 1), x1 = fixed(width - right, 1);
  std::string svg = "<rect class='wanted' x='" + x0 + "' y='" + fixed(head, 1) + "' width='" +
                    fixed(width - right - left, 1) + "' height='" + fixed(foot - head, 1) + "'/>";
  for (const auto& [drawn, at] : {std::pair{below, foot}, std::pair{above, head}})
    if (drawn)
      svg += "<line class='edge' x1='" + x0 + "' x2='" + x1 + "' y1='" + fixed(at, 1) + "' y2='" +
             fixed(at, 1) + "'/>";
  return svg + "<text class='tick' x='" + fixed(left + 6, 1) + "' y='" + fixed(head + 14, 1) +
         "'>" + html_escaped(chart.wanted->name) + "</text>";
}

/// Names in as many rows as they need; the first is where a single one would be.
struct Legend {
  std::string svg;
  int rows = 1;
};

Legend legend(const Chart& chart) {
  Legend drawn;
  if (chart.lines.size() < 2) return drawn;
  double at = left;
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    const double space = 36.0 + 7.4 * static_cast<double>(chart.lines[i].name.size());
    if (at > left && at + space > width) {
      at = left;
      ++drawn.rows;
    }
    const double y = 14.0 + legend_row * (drawn.rows - 1);
    drawn.svg += "<line x1='" + fixed(at, 1) + "' x2='" + fixed(at + 18, 1) + "' y1='" +
                 fixed(y, 0) + "' y2='" + fixed(y, 0) + "' stroke='var(--line-" +
                 std::to_string(i % line_colours) + ")' stroke-width='3'/><text class='tick' x='" +
                 fixed(at + 23, 1) + "' y='" + fixed(y + 4, 0) + "'>" +
                 html_escaped(chart.lines[i].name) + "</text>";
    at += space;
  }
  return drawn;
}

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  return escaped;
}

std::vector<double> round_ticks(double low, double high, int count) {
  const double span = high > low ? high - low : std::max(std::abs(high), 1.0);
  const double raw = span / count;
  const double decade = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * decade;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * decade >= raw * (1.0 - 1e-9)) step = factor * decade;
  const double first = std::floor(low / step + 1e-9),
               last = std::max(std::ceil(high / step - 1e-9), first + 1.0);
  std::vector<double> ticks;
  for (double tick = first; tick <= last + 0.5; tick += 1.0) ticks.push_back(tick * step);
  return ticks;
}

ChartBand band_around(const ChartLine& line, double share) {
  ChartBand band{line.x, line.y, line.y, line.y};
  for (std::size_t i = 0; i < line.y.size(); ++i) {
    band.low[i] -= share * std::abs(line.y[i]);
    band.high[i] += share * std::abs(line.y[i]);
  }
  return band;
}

std::string svg_chart(const Chart& chart) {
  const Axis x = axis_over(all_x(chart), false, 7);
  const Axis y = axis_over(all_y(chart), true, 5);
  const Legend names = legend(chart);
  const double above = legend_row * (names.rows - 1);  // further rows of names stand above the rest
  std::string svg = "<svg class='chart' viewBox='0 " + fixed(above > 0.0 ? -above : 0.0, 0) +
                    " 640 " + fixed(height + above, 0) + "' role='img' aria-label='" +
                    html_escaped(chart.title) + "'>" + region_beyond(chart, x) +
                    region_wanted(chart, y) + grid(x, y) + "<g transform='translate(0 " +
                    fixed(above > 0.0 ? -above : 0.0, 0) + ")'>" + names.svg + "</g>";
  for (std::size_t i = 0; i < chart.lines.size(); ++i) svg += band_of(chart.lines[i], i, x, y);
  for (std::size_t i = 0; i < chart.lines.size(); ++i)
    svg += "<path class='line' style='stroke:var(--line-" + std::to_string(i % line_colours) +
           ")' d='" + path_of(chart.lines[i], x, y) + "'><title>" +
           html_escaped(chart.lines[i].name) + "</title></path>";
  svg += "<text class='label' text-anchor='middle' x='" + fixed((left + width - right) / 2, 1) +
         "' y='" + fixed(height - 8, 1) + "'>" + html_escaped(chart.x_label) +
         "</text><text class='label' text-anchor='middle' transform='translate(14 " +
         fixed((top + height - bottom) / 2, 1) + ") rotate(-90)'>" + html_escaped(chart.y_label) +
         "</text></svg>";
  return svg;
}

}  // namespace dccast::client::render
