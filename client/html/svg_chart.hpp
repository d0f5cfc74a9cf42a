#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dccast::client::render {

/// A dashed line with a shaded interval around it.
///
/// Units: x, y, their limits and ticks in the units named in the axis labels of the chart.
struct ChartBand {
  /// Abscissa and lower end of a band.
  std::vector<double> x;
  std::vector<double> middle;  ///< as long as x, all finite
  std::vector<double> low;
  std::vector<double> high;
};

/// One line of a chart.
struct ChartLine {
  /// A curve with its name for the legend.
  std::string name;
  std::vector<double> x;
  std::vector<double> y;  ///< as long as x; points that are not finite break the line
  ChartBand band{};       ///< in the line's colour; empty: none
  bool dots = false;      ///< readings: a dot for each point, no line
};

/// A band around a line. @param lower, upper  its width on each side, by point, in the unit of y
ChartBand band_around(const ChartLine& line, const std::vector<double>& lower,
                      const std::vector<double>& upper);

/// A chart with its axes; numbers are in the units of the axes' titles.
struct Chart {
  std::string title;    ///< read out by screen readers
  std::string x_label;  ///< with its unit
  std::string y_label;
  std::vector<ChartLine> lines;
  /// x from which the region to the right end is hatched and named; absent: no region.
  std::optional<double> beyond_from{};
  std::string beyond_name{};
  /// A named horizontal region of desired values. A NaN or infinite limit reaches to the end of the
  /// axis.
  struct Wanted {
    /// A range that the plant wants, drawn as a band over the whole width.
    double low;
    double high;
    std::string name;
  };
  std::optional<Wanted> wanted{};
};

/// A chart as inline SVG with axes, round ticks and a legend. Colours come from the page's CSS
/// variables --line-0 ... --line-5, so that it follows the light and the dark scheme.
std::string svg_chart(const Chart& chart);

/// About `count` round numbers, from at most `low` to at least `high`.
std::vector<double> round_ticks(double low, double high, int count);

/// Text with &, <, > and quotes made safe for HTML.
std::string html_escaped(const std::string& text);

/// Elements of a drawing, in units of the view box. @param attributes  "class='tick'"
std::string svg_text(const std::string& attributes, double x, double y, const std::string& text);
/// A rectangle. @param attributes  SVG, such as a class
std::string svg_box(const std::string& attributes, double x, double y, double wide, double high);

/// The name of a vertical axis, read upwards along the left edge about `middle`.
std::string svg_name_upwards(double middle, const std::string& text);

}  // namespace dccast::client::render
