#include "client/html/svg_chart.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include <fmt/core.h>

#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

// Sizes in the view box; the page scales it.
constexpr double width = 640, height = 320, left = 62, right = 16, top = 30, bottom = 46;
constexpr double legend_row = 17;

struct Axis {
  std::vector<double> ticks;
  double low, high;

  double part(double value) const { return (value - low) / (high - low); }
  std::string tick_text(double value) const {
    const double step = ticks[1] - ticks[0];
    const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
    return fixed(std::abs(value) < 1e-9 * step ? 0.0 : value, decimals);
  }
};

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
    // A value slightly below zero, such as the edge of a band, must not add a whole step to the
    // axis.
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

/// The axes of a chart, and where in the view box a value is.
struct Plot {
  Axis x_axis, y_axis;

  double x(double value) const { return left + x_axis.part(value) * (width - left - right); }
  double y(double value) const {
    return height - bottom - y_axis.part(value) * (height - top - bottom);
  }
};

Plot plot_of(const Chart& chart) {
  std::vector<double> x, y;
  const auto append = [](std::vector<double>& all, const std::vector<double>& values) {
    all.insert(all.end(), values.begin(), values.end());
  };
  for (const ChartLine& line : chart.lines) {
    for (const auto* part : {&line.x, &line.band.x}) append(x, *part);
    for (const auto* part : {&line.y, &line.band.low, &line.band.high}) append(y, *part);
  }
  if (chart.wanted) append(y, {chart.wanted->low, chart.wanted->high});
  return {axis_over(x, false, 7), axis_over(y, true, 5)};
}

std::string line(const std::string& kind, double x1, double x2, double y1, double y2) {
  return fmt::format("<line class='{}' x1='{:.1f}' x2='{:.1f}' y1='{:.1f}' y2='{:.1f}'/>", kind, x1,
                     x2, y1, y2);
}

std::string grid(const Plot& plot) {
  std::string svg;
  for (const double tick : plot.y_axis.ticks) {
    const double y = plot.y(tick);
    svg += line(tick == 0.0 ? "zero" : "grid", left, width - right, y, y) +
           svg_text("class='tick' text-anchor='end'", left - 6, y + 4, plot.y_axis.tick_text(tick));
  }
  for (const double tick : plot.x_axis.ticks) {
    const double x = plot.x(tick);
    svg += line("grid", x, x, top, height - bottom) + svg_text("class='tick' text-anchor='middle'",
                                                               x, height - bottom + 17,
                                                               plot.x_axis.tick_text(tick));
  }
  return svg;
}

std::string path_of(const std::vector<double>& x, const std::vector<double>& y, const Plot& plot) {
  std::string path;
  bool pen_down = false;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    const bool drawable = std::isfinite(x[i]) && std::isfinite(y[i]);
    if (drawable)
      path += fmt::format("{}{:.2f} {:.2f}", pen_down ? "L" : "M", plot.x(x[i]), plot.y(y[i]));
    pen_down = drawable;
  }
  return path;
}

std::string colour_of_line(std::size_t number) {
  constexpr std::size_t line_colours = 6;
  return fmt::format("var(--line-{})", number % line_colours);
}

/// A dot for each point of a line.
std::string dots_of(const ChartLine& line, std::size_t number, const Plot& plot) {
  std::string svg = fmt::format("<g style='fill:{}'><title>{}</title>", colour_of_line(number),
                                html_escaped(line.name));
  for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i)
    if (std::isfinite(line.x[i]) && std::isfinite(line.y[i]))
      svg += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2.5'/>", plot.x(line.x[i]),
                         plot.y(line.y[i]));
  return svg + "</g>";
}

/// Shaded from low to high, with the middle dashed. Below all lines: it must not hide them.
std::string band_of(const ChartLine& line, std::size_t number, const Plot& plot) {
  const ChartBand& band = line.band;
  if (band.x.empty()) return {};
  std::vector<double> x = band.x, y = band.high;
  x.insert(x.end(), band.x.rbegin(), band.x.rend());
  y.insert(y.end(), band.low.rbegin(), band.low.rend());
  const std::string colour = colour_of_line(number);
  return fmt::format(
      "<path class='band' style='fill:{}' d='{}Z'/>"
      "<path class='middle' style='stroke:{}' d='{}'><title>{}, limit</title></path>",
      colour, path_of(x, y, plot), colour, path_of(band.x, band.middle, plot),
      html_escaped(line.name));
}

/// Drawn behind everything else, with the name at the top of the region.
std::string region_beyond(const Chart& chart, const Plot& plot) {
  if (!chart.beyond_from) return {};
  const double from = std::clamp(plot.x(*chart.beyond_from), left, width - right);
  return svg_box("class='beyond'", from, top, width - right - from, height - top - bottom) +
         svg_text("class='tick' text-anchor='end'", width - right - 4, height - bottom - 6,
                  chart.beyond_name);
}

/// Dashed edges of the region, with the name under the upper one.
std::string region_wanted(const Chart& chart, const Plot& plot) {
  if (!chart.wanted) return {};
  const bool below = std::isfinite(chart.wanted->low), above = std::isfinite(chart.wanted->high);
  const double foot = below ? plot.y(chart.wanted->low) : height - bottom,
               head = above ? plot.y(chart.wanted->high) : top;
  std::string svg = svg_box("class='wanted'", left, head, width - right - left, foot - head);
  for (const auto& [drawn, at] : {std::pair{below, foot}, std::pair{above, head}})
    if (drawn) svg += line("edge", left, width - right, at, at);
  return svg + svg_text("class='tick'", left + 6, head + 14, chart.wanted->name);
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
    const std::string& name = chart.lines[i].name;
    const double space = 36.0 + 7.4 * static_cast<double>(name.size());
    if (at > left && at + space > width) {
      at = left;
      ++drawn.rows;
    }
    const double y = 14.0 + legend_row * (drawn.rows - 1);
    drawn.svg += fmt::format(
        "<line x1='{:.1f}' x2='{:.1f}' y1='{:.0f}' y2='{:.0f}' stroke='{}' stroke-width='3'/>"
        "<text class='tick' x='{:.1f}' y='{:.0f}'>{}</text>",
        at, at + 18, y, y, colour_of_line(i), at + 23, y + 4, html_escaped(name));
    at += space;
  }
  return drawn;
}

}  // namespace

std::string html_escaped(const std::string& text) {
  constexpr std::string_view special = "&<>\"'";
  constexpr const char* names[] = {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
  std::string escaped;
  for (const char c : text) {
    const auto at = special.find(c);
    escaped += at == special.npos ? std::string(1, c) : names[at];
  }
  return escaped;
}

std::string svg_text(const std::string& attributes, double x, double y, const std::string& text) {
  return fmt::format("<text {} x='{:.1f}' y='{:.1f}'>{}</text>", attributes, x, y,
                     html_escaped(text));
}

std::string svg_box(const std::string& attributes, double x, double y, double wide, double high) {
  return fmt::format("<rect {} x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}'/>", attributes,
                     x, y, wide, high);
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

ChartBand band_around(const ChartLine& line, const std::vector<double>& lower,
                      const std::vector<double>& upper) {
  ChartBand band{line.x, line.y, line.y, line.y};
  for (std::size_t i = 0; i < line.y.size(); ++i) {
    band.low[i] -= lower[i];
    band.high[i] += upper[i];
  }
  return band;
}

std::string svg_chart(const Chart& chart) {
  const Plot plot = plot_of(chart);
  const Legend names = legend(chart);
  const double above = legend_row * (names.rows - 1);  // further rows of names stand above the rest
  std::string svg =
      fmt::format("<svg class='chart' viewBox='0 {:.0f} 640 {:.0f}' role='img' aria-label='{}'>",
                  0.0 - above, height + above, html_escaped(chart.title)) +
      region_beyond(chart, plot) + region_wanted(chart, plot) + grid(plot) +
      fmt::format("<g transform='translate(0 {:.0f})'>{}</g>", 0.0 - above, names.svg);
  for (std::size_t i = 0; i < chart.lines.size(); ++i) svg += band_of(chart.lines[i], i, plot);
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    const ChartLine& line = chart.lines[i];
    if (line.dots) {
      svg += dots_of(line, i, plot);
      continue;
    }
    svg += fmt::format("<path class='line' style='stroke:{}' d='{}'><title>{}</title></path>",
                       colour_of_line(i), path_of(line.x, line.y, plot), html_escaped(line.name));
  }
  return svg +
         svg_text("class='label' text-anchor='middle'", (left + width - right) / 2, height - 8,
                  chart.x_label) +
         svg_name_upwards((top + height - bottom) / 2, chart.y_label) + "</svg>";
}

std::string svg_name_upwards(double middle, const std::string& text) {
  return fmt::format(
      "<text class='label' text-anchor='middle' transform='translate(14 {:.1f}) "
      "rotate(-90)'>{}</text>",
      middle, html_escaped(text));
}

}  // namespace dccast::client::render
