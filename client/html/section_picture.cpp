#include "client/html/section_picture.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "client/html/colour_bands.hpp"
#include "client/html/frame_surface.hpp"
#include "client/html/isotherms.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

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

std::vector<Point> nodes_of(const v1::Frame& frame, double displacement_scale) {
  std::vector<Point> nodes(static_cast<std::size_t>(frame.node_m_size() / 2));
  const std::vector<double> displacement = drawn_displacement(frame);
  const auto drawn = [&](std::size_t at) {
    return frame.node_m(static_cast<int>(at)) +
           (displacement.empty() ? 0.0 : displacement_scale * displacement[at]);
  };
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = {drawn(2 * i), drawn(2 * i + 1)};
  return nodes;
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
                 const std::vector<std::array<int, 3>>& triangles, const ColourBands& bands) {
  std::map<int, std::string> path_of_band;
  for (const auto& t : triangles)
    for (const BandPiece& piece :
         band_pieces({node[t[0]], node[t[1]], node[t[2]]},
                     {temperature[t[0]], temperature[t[1]], temperature[t[2]]}, bands))
      for (std::size_t k = 0; k < piece.outline.size(); ++k)
        path_of_band[piece.band] += (k == 0 ? "M" : "L") + point_text(view, piece.outline[k]) +
                                    (k + 1 == piece.outline.size() ? "z" : "");
  std::string svg;
  for (const auto& [band, path] : path_of_band) {
    const std::string colour = bands.colour(band);
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

}  // namespace

bool consistent(const v1::Frame& frame) {
  const int nodes = frame.temperature_c_size();
  if (frame.dimension() != 2 || nodes == 0 || frame.node_m_size() != 2 * nodes) return false;
  if (frame.displacement_m_size() != 0 && frame.displacement_m_size() != 2 * nodes) return false;
  const bool drawable = frame.nodes_per_element() == 3 || frame.nodes_per_element() == 4;
  return drawable && std::all_of(frame.element_node().begin(), frame.element_node().end(),
                                 [&](int node) { return node >= 0 && node < nodes; });
}

SectionPicture draw_section(const v1::Frame& frame, const std::optional<ColourRange>& range) {
  if (!consistent(frame)) return {};
  SectionPicture picture;
  picture.displacement_scale = displacement_scale(frame);
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
  const ColourBands bands =
      range ? ColourBands{range->low, range->high} : ColourBands{*low, std::max(*high, *low + 1.0)};
  picture.view = {.across = {view.scale, 0.0, 0.0, view.x(0.0)},
                  .down = {0.0, -view.scale, 0.0, view.y(0.0)}};
  picture.svg = "<svg class='section' viewBox='0 0 " + fixed(view.width(), 0) + " " +
                fixed(view.height(), 0) +
                "' role='img' aria-label='Deformed section with isotherms'><g class='now'>" +
                fill(view, node, temperature, triangles, bands) +
                outline(view, still, triangles, "undeformed") +
                outline(view, node, triangles, "deformed") +
                isotherms(view, node, temperature, triangles, frame) + "</g>" +
                axes(view, width_m, height_m) +
                colour_bar(bands, "°C", view.width() - margin_right + 24, margin_top,
                           view.height() - margin_top - margin_bottom) +
                "</svg>";
  return picture;
}

}  // namespace dccast::client::render
