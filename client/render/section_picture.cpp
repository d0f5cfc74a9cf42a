#include "client/render/section_picture.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "client/render/isotherms.hpp"
#include "client/render/svg_chart.hpp"
#include "client/render/table.hpp"

namespace dccast::client::render {
namespace {

constexpr int bands = 28;  // of the colour fill
constexpr double drawing_width = 560, margin_left = 56, margin_top = 24, margin_bottom = 46,
                 margin_right = 100;

/// Frame of the drawing: metres to the view box.
struct View {
  double x0, y0, x1, y1;  // extent of what is drawn [m]
  double scale;           // view box units per metre

  double x(double metres) const { return margin_left + (metres - x0) * scale; }
  double y(double metres) const { return margin_top + (y1 - metres) * scale; }
  double width() const { return margin_left + (x1 - x0) * scale + margin_right; }
  double height() const { return margin_top + (y1 - y0) * scale + margin_bottom; }
};

/// Cold blue over violet to hot yellow; even in lightness, readable on white and on black.
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

std::vector<Point> nodes_of(const v1::Frame& frame, double displacement_scale) {
  std::vector<Point> nodes(static_cast<std::size_t>(frame.node_m_size() / 2));
  const bool moved = frame.displacement_m_size() == frame.node_m_size();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const int at = static_cast<int>(2 * i);
    nodes[i] = {
        frame.node_m(at) + (moved ? displacement_scale * frame.displacement_m(at) : 0.0),
        frame.node_m(at + 1) + (moved ? displacement_scale * frame.displacement_m(at + 1) : 0.0)};
  }
  return nodes;
}

/// Largest displacement of the bottom, or of all nodes where no bottom is named.
double displacement_to_show(const v1::Frame& frame, double largest) {
  double shown = 0.0;
  for (const int node : frame.bottom_node())
    if (node >= 0 && 2 * node + 1 < frame.displacement_m_size())
      shown = std::max(
          shown, std::hypot(frame.displacement_m(2 * node), frame.displacement_m(2 * node + 1)));
  return shown > 0.0 ? shown : largest;
}

/// A round factor (1, 2, 5, 10, ...) that shows the curl of the butt and keeps the picture whole:
/// metal near the level may have moved much further than the bottom.
double scale_for(const v1::Frame& frame) {
  double largest = 0.0, extent = 0.0;
  for (int i = 0; 2 * i + 1 < std::min(frame.displacement_m_size(), frame.node_m_size()); ++i) {
    extent = std::max(extent, frame.node_m(2 * i));
    largest =
        std::max(largest, std::hypot(frame.displacement_m(2 * i), frame.displacement_m(2 * i + 1)));
  }
  if (!(largest > 0.0)) return 1.0;
  const double wanted =
      std::min(extent / (15.0 * displacement_to_show(frame, largest)), 0.25 * extent / largest);
  if (wanted < 2.0) return 1.0;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  return decade * (wanted / decade >= 5.0 ? 5.0 : wanted / decade >= 2.0 ? 2.0 : 1.0);
}

View view_of(const std::vector<Point>& drawn, const std::vector<Point>& still) {
  View view{0.0, 0.0, 0.0, 0.0, 1.0};
  for (const auto* nodes : {&drawn, &still})
    for (const Point& p : *nodes) {
      view.x0 = std::min(view.x0, p.x);
      view.x1 = std::max(view.x1, p.x);
      view.y0 = std::min(view.y0, p.y);
      view.y1 = std::max(view.y1, p.y);
    }
  view.scale = drawing_width / std::max({view.x1 - view.x0, view.y1 - view.y0, 1e-6});
  return view;
}

std::string point_text(const View& view, const Point& p) {
  return fixed(view.x(p.x), 1) + " " + fixed(view.y(p.y), 1);
}

std::string fill(const View& view, const std::vector<Point>& node,
                 const std::vector<double>& temperature,
                 const std::vector<std::array<int, 3>>& triangles, double low, double high) {
  std::map<int, std::string> path_of_band;
  for (const auto& t : triangles) {
    const double mean = (temperature[t[0]] + temperature[t[1]] + temperature[t[2]]) / 3.0;
    const int band = std::clamp(static_cast<int>(bands * (mean - low) / std::max(high - low, 1e-9)),
                                0, bands - 1);
    path_of_band[band] += "M" + point_text(view, node[t[0]]) + "L" + point_text(view, node[t[1]]) +
                          "L" + point_text(view, node[t[2]]) + "z";
  }
  std::string svg;
  for (const auto& [band, path] : path_of_band) {
    const std::string colour = band_colour((band + 0.5) / bands);
    svg +=
        "<path fill='" + colour + "' stroke='" + colour + "' stroke-width='.4' d='" + path + "'/>";
  }
  return svg;
}

/// Edges that belong to one triangle only.
std::string outline(const View& view, const std::vector<Point>& node,
                    const std::vector<std::array<int, 3>>& triangles,
                    const std::string& css_class) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) ++uses[std::minmax(t[i], t[(i + 1) % 3])];
  std::string path;
  for (const auto& [edge, count] : uses)
    if (count == 1)
      path += "M" + point_text(view, node[edge.first]) + "L" + point_text(view, node[edge.second]);
  return "<path class='" + css_class + "' d='" + path + "'/>";
}

std::string isotherm_path(const View& view, const std::vector<Segment>& segments,
                          const std::string& css_class, const std::string& name) {
  std::string path;
  for (const Segment& s : segments)
    path += "M" + point_text(view, s[0]) + "L" + point_text(view, s[1]);
  return "<path class='" + css_class + "' d='" + path + "'><title>" + name + "</title></path>";
}

/// At the symmetry plane where an isotherm reaches it, else at its uppermost point.
std::string isotherm_label(const View& view, const std::vector<Segment>& segments,
                           const std::string& text) {
  Point at = segments.front()[0];
  for (const Segment& s : segments)
    for (const Point& p : s)
      if (p.x < at.x - 1e-9) at = p;
  return "<text class='isotherm-label' x='" + fixed(view.x(at.x) + 3, 1) + "' y='" +
         fixed(view.y(at.y) - 3, 1) + "'>" + text + "</text>";
}

std::string isotherms(const View& view, const std::vector<Point>& node,
                      const std::vector<double>& temperature,
                      const std::vector<std::array<int, 3>>& triangles, const v1::Frame& frame) {
  std::string svg;
  for (int level = 100; level <= 600; level += 100) {
    const auto segments = isotherm(node, temperature, triangles, level);
    if (segments.empty()) continue;
    const std::string name = std::to_string(level) + " °C";
    svg += isotherm_path(view, segments, "isotherm", name) +
           isotherm_label(view, segments, std::to_string(level));
  }
  for (const auto& [level, name] :
       {std::pair{frame.solidus_c(), "solidus"}, std::pair{frame.liquidus_c(), "liquidus"}}) {
    const auto segments = isotherm(node, temperature, triangles, level);
    if (!segments.empty())
      svg += isotherm_path(view, segments, std::string("front ") + name,
                           std::string(name) + " " + fixed(level, 0) + " °C");
  }
  return svg;
}

std::string axes(const View& view, double width_m, double height_m) {
  std::string svg;
  const double foot = view.y(view.y0);
  for (const double tick : round_ticks(0.0, 1e3 * width_m, 6))
    if (tick <= 1e3 * view.x1 + 1e-6)
      svg += "<text class='tick' text-anchor='middle' x='" + fixed(view.x(tick / 1e3), 1) +
             "' y='" + fixed(foot + 18, 1) + "'>" + fixed(tick, 0) + "</text>";
  for (const double tick : round_ticks(0.0, 1e3 * height_m, 4))
    if (tick <= 1e3 * view.y1 + 1e-6)
      svg += "<text class='tick' text-anchor='end' x='" + fixed(margin_left - 8, 1) + "' y='" +
             fixed(view.y(tick / 1e3) + 4, 1) + "'>" + fixed(tick, 0) + "</text>";
  return svg + "<text class='label' text-anchor='middle' x='" +
         fixed(view.x((view.x0 + view.x1) / 2), 1) + "' y='" + fixed(foot + 38, 1) +
         "'>distance from the symmetry plane, mm</text><text class='label' text-anchor='middle' "
         "transform='translate(14 " +
         fixed((view.y(view.y1) + foot) / 2, 1) + ") rotate(-90)'>height, mm</text>";
}

std::string colour_bar(const View& view, double low, double high) {
  const double x = view.width() - margin_right + 24, top = margin_top,
               bar = view.height() - margin_top - margin_bottom;
  std::string svg;
  for (int band = 0; band < bands; ++band)
    svg += "<rect x='" + fixed(x, 1) + "' y='" + fixed(top + bar * (bands - 1 - band) / bands, 1) +
           "' width='12' height='" + fixed(bar / bands + 0.5, 1) + "' fill='" +
           band_colour((band + 0.5) / bands) + "'/>";
  for (const double level : round_ticks(low, high, 5))
    if (level >= low - 1e-9 && level <= high + 1e-9)
      svg += "<text class='tick' x='" + fixed(x + 17, 1) + "' y='" +
             fixed(top + bar * (high - level) / (high - low) + 4, 1) + "'>" + fixed(level, 0) +
             "</text>";
  return svg + "<text class='label' x='" + fixed(x, 1) + "' y='" + fixed(top - 8, 1) +
         "'>°C</text>";
}

}  // namespace

bool consistent(const v1::Frame& frame) {
  const int nodes = frame.temperature_c_size();
  if (frame.dimension() != 2 || nodes == 0 || frame.node_m_size() != 2 * nodes) return false;
  if (frame.displacement_m_size() != 0 && frame.displacement_m_size() != 2 * nodes) return false;
  const bool drawable = frame.nodes_per_element() == 3 || frame.nodes_per_element() == 4;
  return drawable && std::all_of(frame.element_node().begin(), frame.element_node().end(),
                                 [&](int node) { return node >= 0 && node < nodes; });
}

SectionPicture draw_section(const v1::Frame& frame) {
  if (!consistent(frame)) return {};
  SectionPicture picture;
  picture.displacement_scale = scale_for(frame);
  const auto node = nodes_of(frame, picture.displacement_scale);
  const auto still = nodes_of(frame, 0.0);
  const std::vector<double> temperature(frame.temperature_c().begin(), frame.temperature_c().end());
  const auto triangles = triangles_of({frame.element_node().begin(), frame.element_node().end()},
                                      frame.nodes_per_element());
  const View view = view_of(node, still);
  double width_m = 0.0, height_m = 0.0;
  for (const Point& p : still) {
    width_m = std::max(width_m, p.x);
    height_m = std::max(height_m, p.y);
  }
  const auto [low, high] = std::minmax_element(temperature.begin(), temperature.end());
  const double span_low = *low, span_high = std::max(*high, *low + 1.0);
  picture.svg =
      "<svg class='section' viewBox='0 0 " + fixed(view.width(), 0) + " " +
      fixed(view.height(), 0) + "' role='img' aria-label='Deformed section with isotherms'>" +
      fill(view, node, temperature, triangles, span_low, span_high) +
      outline(view, still, triangles, "undeformed") + outline(view, node, triangles, "deformed") +
      isotherms(view, node, temperature, triangles, frame) + axes(view, width_m, height_m) +
      colour_bar(view, span_low, span_high) + "</svg>";
  return picture;
}

}  // namespace dccast::client::render
