#include "tests/verification/program/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <map>

#include "tests/verification/program/table.hpp"

namespace dccast::verification {

namespace {

constexpr double width = 376, height = 300, left = 64, right = 14, top = 34, bottom = 46;
constexpr std::array<const char*, 5> colours{"#1f5f99", "#c2571a", "#3f7f3f", "#7a4a9e", "#555"};

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char text[512];
  std::va_list values;
  va_start(values, pattern);
  std::vsnprintf(text, sizeof text, pattern, values);
  va_end(values);
  return text;
}

/// An axis with a small margin around its values.
struct Axis {
  double from, to;  ///< picture coordinates
  bool logarithmic;
  double low = 1e300, high = -1e300;

  void include(double value) {
    low = std::min(low, logarithmic ? value / 1.25 : value);
    high = std::max(high, logarithmic ? value * 1.25 : value);
  }
  double position(double value) const {
    const double share = logarithmic ? std::log(value / low) / std::log(high / low)
                                     : 0.03 + 0.94 * (value - low) / (high - low);
    return from + (to - from) * share;
  }
  std::vector<double> ticks() const { return logarithmic ? decades() : round_steps(); }

private:
  /// 1, 2 and 5 in every decade; 1 only if the axis spans more than two decades.
  std::vector<double> decades() const {
    std::vector<double> found;
    const bool fine = high / low < 100.0;
    for (int d = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, d) < high; ++d) {
      for (double m : {1.0, 2.0, 5.0}) {
        const double tick = m * std::pow(10.0, d);
        if (tick >= low && tick <= high && (fine || m == 1.0)) found.push_back(tick);
      }
    }
    return found;
  }
  /// Multiples of 1, 2 or 5 times a power of ten, some five of them.
  std::vector<double> round_steps() const {
    const double wanted = (high - low) / 5.0,
                 power = std::pow(10.0, std::floor(std::log10(wanted)));
    const double step = power * (wanted < 2.0 * power ? 2.0 : wanted < 5.0 * power ? 5.0 : 10.0);
    std::vector<double> found;
    for (double k = std::ceil(low / step); k * step <= high; ++k)
      found.push_back(k * step + 0.0);  // no -0
    return found;
  }
};

std::string grid(const Axis& x, const Axis& y) {
  std::string out;
  for (double tick : x.ticks()) {
    out += format("<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" class=\"grid\"/>",
                  x.position(tick), x.position(tick), y.to, y.from);
    out += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%g</text>", x.position(tick),
                  y.from + 18, tick);
  }
  for (double tick : y.ticks()) {
    out += format("<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" class=\"grid\"/>", x.from,
                  x.to, y.position(tick), y.position(tick));
    out += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%g</text>", x.from - 8,
                  y.position(tick) + 4, tick);
  }
  return out;
}

std::string draw_curve(const Curve2D& curve, const Axis& x, const Axis& y, const char* colour) {
  std::string path;
  const bool reference = curve.slope != 0.0;
  for (const auto& [px, py] : curve.points) {
    path += format("%s%.1f %.1f", path.empty() ? "M" : "L", x.position(px), y.position(py));
  }
  std::string out =
      "<path d=\"" + path + "\"" +
      format(" fill=\"none\" stroke=\"%s\" stroke-width=\"%s\"%s/>", reference ? "#999" : colour,
             reference ? "1.2" : "2", reference ? " stroke-dasharray=\"5 4\"" : "");
  constexpr std::size_t few = 12;
  if (reference || curve.points.size() > few) return out;

  for (const auto& [px, py] : curve.points) {
    out += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.4\" fill=\"%s\"/>", x.position(px),
                  y.position(py), colour);
  }
  return out;
}

std::string head(const std::string& title, double w, double h) {
  return format(
             "<svg viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" height=\"%.0f\" role=\"img\" "
             "xmlns=\"http://www.w3.org/2000/svg\" font-family=\"Helvetica, Arial, sans-serif\" "
             "font-size=\"12\" fill=\"#333\">",
             w, h, w, h) +
         "<style>.grid{stroke:#e3e6ea;stroke-width:1}</style>" +
         format("<text x=\"%.0f\" y=\"18\" font-size=\"14\" font-weight=\"600\">", 8.0) +
         escaped(title) + "</text>";
}

/// Blue through white to red.
std::string diverging_colour(double share) {
  const double s = std::clamp(share, -1.0, 1.0), fade = 1.0 - std::abs(s);
  const double strong[3] = {s < 0 ? 33.0 : 178.0, s < 0 ? 90.0 : 34.0, s < 0 ? 160.0 : 40.0};
  return format("#%02x%02x%02x", int(strong[0] + fade * (247 - strong[0])),
                int(strong[1] + fade * (247 - strong[1])),
                int(strong[2] + fade * (247 - strong[2])));
}

std::string curves_svg(const std::string& title, const std::string& x_label,
                       const std::vector<Curve2D>& curves, bool logarithmic) {
  Axis x{left, width - right, logarithmic}, y{height - bottom, top, logarithmic};
  for (const auto& curve : curves) {
    for (const auto& [px, py] : curve.points) {
      x.include(px);
      y.include(py);
    }
  }

  // The legend stands below the axis of a chart, and in the free corner of falling errors.
  const double below = logarithmic ? 0.0 : 16.0 * double(curves.size());
  std::string out = head(title, width, height + below) + grid(x, y);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const char* colour = colours[i % colours.size()];
    out += draw_curve(curves[i], x, y, colour);

    const double row = logarithmic ? height - bottom - 12 - 16.0 * double(curves.size() - 1 - i)
                                   : height + 8 + 16.0 * double(i);
    out += format(
        "<rect x=\"%.1f\" y=\"%.1f\" width=\"150\" height=\"16\" fill=\"white\" "
        "fill-opacity=\".8\"/><line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" "
        "stroke=\"%s\" stroke-width=\"2\"/>",
        width - right - 156, row - 12, width - right - 150, width - right - 130, row - 4, row - 4,
        curves[i].slope != 0.0 ? "#999" : colour);
    out += format("<text x=\"%.1f\" y=\"%.1f\">", width - right - 124, row) +
           escaped(curves[i].name) + "</text>";
  }

  out += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", 0.5 * (left + width - right),
                height - 8) +
         escaped(x_label) + "</text>";
  return out + "</svg>\n";
}

}  // namespace

std::string log_log_svg(const std::string& title, const std::string& x_label,
                        const std::vector<Curve2D>& curves) {
  return curves_svg(title, x_label, curves, true);
}

std::string chart_svg(const std::string& title, const std::string& x_label,
                      const std::vector<Curve2D>& curves) {
  return curves_svg(title, x_label, curves, false);
}

std::string outlines_svg(const std::string& title, const std::vector<Polygon>& polygons) {
  double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
  for (const Polygon& polygon : polygons) {
    for (const auto& corner : polygon) {
      for (int d : {0, 1}) {
        low[d] = std::min(low[d], corner[std::size_t(d)]);
        high[d] = std::max(high[d], corner[std::size_t(d)]);
      }
    }
  }

  constexpr double largest = 330, edge = 12;
  const double scale = largest / std::max(high[0] - low[0], high[1] - low[1]);
  std::string path;
  for (const Polygon& polygon : polygons) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      path += format("%c%.1f %.1f", i == 0 ? 'M' : 'L', edge + scale * (polygon[i][0] - low[0]),
                     30 + scale * (high[1] - polygon[i][1]));
    }
    path += "Z";
  }
  constexpr double title_width = 270;
  return head(title, std::max(scale * (high[0] - low[0]) + 2 * edge, title_width),
              scale * (high[1] - low[1]) + 30 + edge) +
         "<path fill=\"#e8eef5\" stroke=\"#1f5f99\" stroke-width=\".5\" d=\"" + path +
         "\"/></svg>\n";
}

std::string field_svg(const std::string& title, const mesh::Mesh2D& mesh,
                      const std::vector<double>& value, double limit, const std::string& unit) {
  double x_low = 1e300, x_high = -1e300, y_high = -1e300;
  for (int n = 0; n < mesh.nodes(); ++n) {
    x_low = std::min(x_low, mesh.point(n)[0]);
    x_high = std::max(x_high, mesh.point(n)[0]);
    y_high = std::max(y_high, mesh.point(n)[1]);
  }

  constexpr double picture = 250, edge = 12;
  const double scale = picture / (x_high - x_low), high = scale * y_high;
  std::string out = head(title, picture + 2 * edge + 90, high + 30 + edge);

  // One path per shade: thousands of elements become some forty shapes.
  std::map<int, std::string> path;
  for (int e = 0; e < mesh.elements(); ++e) {
    const double share = std::clamp(value[std::size_t(e)] / limit, -1.0, 1.0);
    std::string& d = path[static_cast<int>(std::lround(20.0 * share))];
    for (int i = 0; i < mesh.nodes_per_element; ++i) {
      const double* p = mesh.point(mesh.nodes_of(e)[i]);
      d += format("%c%.1f %.1f", i == 0 ? 'M' : 'L', edge + scale * (p[0] - x_low),
                  30 + high - scale * p[1]);
    }
    d += "Z";
  }
  for (const auto& [shade, d] : path) {
    const std::string colour = diverging_colour(shade / 20.0);
    out += format("<path fill=\"%s\" stroke=\"%s\" stroke-width=\".5\" d=\"", colour.c_str(),
                  colour.c_str());
    out += d;
    out += "\"/>";
  }

  // The colour scale.
  constexpr int shades = 20;
  const double least = std::ranges::any_of(value, [](double v) { return v < 0.0; }) ? -1.0 : 0.0;
  for (int i = 0; i < shades; ++i) {
    out += format("<rect x=\"%.1f\" y=\"%.1f\" width=\"14\" height=\"%.1f\" fill=\"%s\"/>",
                  picture + 2 * edge, 40 + i * 8.0, 8.4,
                  diverging_colour(1.0 - (1.0 - least) * i / (shades - 1.0)).c_str());
  }
  const std::array<std::pair<double, double>, 3> marks{
      {{limit, 48.0}, {0.5 * (1.0 + least) * limit, 124.0}, {least * limit, 200.0}}};
  for (const auto& [mark, mark_y] : marks) {
    out += format("<text x=\"%.1f\" y=\"%.1f\">%.3g</text>", picture + 2 * edge + 20, mark_y, mark);
  }
  out +=
      format("<text x=\"%.1f\" y=\"%.1f\">", picture + 2 * edge, 220.0) + escaped(unit) + "</text>";
  return out + "</svg>\n";
}

}  // namespace dccast::verification
