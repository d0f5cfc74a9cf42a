#include "client/html/gap_map.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "client/html/colour_bands.hpp"
#include "client/html/frame_surface.hpp"
#include "client/html/isotherms.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

constexpr double drawing_width = 520, left = 58, top = 26, bottom = 46, right = 74;

/// The bottom of a frame: triangles in plan with their gap.
struct Bottom {
  std::vector<Point> place;    ///< by node [m]
  std::vector<double> gap_mm;  ///< by node; only that of bottom nodes counts
  std::vector<std::array<int, 3>> triangles;
  double width = 0.0, depth = 0.0;  ///< [m]
};

bool has_bottom(const v1::Frame& frame) {
  return consistent_3d(frame) && frame.bottom_node_size() > 2 &&
         frame.bottom_gap_m_size() == frame.bottom_node_size() &&
         std::ranges::all_of(frame.bottom_node(), [&](int node) {
           return node >= 0 && node < frame.temperature_c_size();
         });
}

Bottom bottom_of(const v1::Frame& frame) {
  Bottom found;
  std::map<int, double> gap;
  for (int i = 0; i < frame.bottom_node_size(); ++i)
    gap[frame.bottom_node(i)] = 1e3 * frame.bottom_gap_m(i);
  for (const Vector3& p : places_of(frame, 0.0)) found.place.push_back({p[0], p[1]});
  found.gap_mm.resize(found.place.size());
  for (const auto& [node, value] : gap) {
    found.gap_mm[static_cast<std::size_t>(node)] = value;
    found.width = std::max(found.width, found.place[static_cast<std::size_t>(node)].x);
    found.depth = std::max(found.depth, found.place[static_cast<std::size_t>(node)].y);
  }
  for (const SurfaceFace& face : surface_of(frame)) {
    if (face.normal[2] > -0.5 ||
        !std::ranges::all_of(face.node, [&](int node) { return gap.contains(node); }))
      continue;
    for (std::size_t i = 1; i + 1 < face.node.size(); ++i)
      found.triangles.push_back({face.node[0], face.node[i], face.node[i + 1]});
  }
  return found;
}

/// Metres in plan to the view box.
struct Plan {
  double scale, height;
  Point operator()(const Point& p) const {
    return {left + p.x * scale, top + height - p.y * scale};
  }
};

std::string text_of(const Point& p) {
  return fixed(p.x, 1) + " " + fixed(p.y, 1);
}

std::string fill(const Bottom& found, const Plan& plan, const ColourBands& bands) {
  std::map<int, std::string> path;
  for (const auto& t : found.triangles)
    for (const BandPiece& piece :
         band_pieces({plan(found.place[t[0]]), plan(found.place[t[1]]), plan(found.place[t[2]])},
                     {found.gap_mm[t[0]], found.gap_mm[t[1]], found.gap_mm[t[2]]}, bands))
      for (std::size_t k = 0; k < piece.outline.size(); ++k)
        path[piece.band] += (k == 0 ? "M" : "L") + text_of(piece.outline[k]) +
                            (k + 1 == piece.outline.size() ? "z" : "");
  std::string svg;
  for (const auto& [band, d] : path)
    svg += "<path fill='" + bands.colour(band) + "' stroke='" + bands.colour(band) +
           "' stroke-width='.5' d='" + d + "'/>";
  return svg;
}

/// Lines of equal gap at the round figures of the colour bar.
std::string lines(const Bottom& found, const Plan& plan, const ColourBands& bands) {
  std::string svg;
  for (const double level : round_ticks(bands.low, bands.high, 5)) {
    if (level <= bands.low || level >= bands.high) continue;
    std::string path;
    for (const Segment& s : isotherm(found.place, found.gap_mm, found.triangles, level))
      path += "M" + text_of(plan(s[0])) + "L" + text_of(plan(s[1]));
    svg +=
        "<path class='isotherm' d='" + path + "'><title>" + fixed(level, 1) + " mm</title></path>";
  }
  return svg;
}

/// Dots on the nodes that press on the block, their area as the pressure.
std::string contacts(const v1::Frame& frame, const Bottom& found, const Plan& plan, int& count) {
  double greatest = 0.0;
  for (const double pressure : frame.bottom_pressure_pa()) greatest = std::max(greatest, pressure);
  std::string svg;
  for (int i = 0; i < std::min(frame.bottom_pressure_pa_size(), frame.bottom_node_size()); ++i) {
    const double pressure = frame.bottom_pressure_pa(i);
    if (!(pressure > 0.0)) continue;
    ++count;
    const Point at = plan(found.place[static_cast<std::size_t>(frame.bottom_node(i))]);
    svg += "<circle class='contact' cx='" + fixed(at.x, 1) + "' cy='" + fixed(at.y, 1) + "' r='" +
           fixed(3.0 + 4.0 * std::sqrt(pressure / greatest), 1) + "'><title>" +
           fixed(1e-3 * pressure, 1) + " kPa</title></circle>";
  }
  return svg;
}

std::string axes(const Bottom& found, const Plan& plan) {
  std::string svg = "<rect class='deformed' x='" + fixed(left, 1) + "' y='" + fixed(top, 1) +
                    "' width='" + fixed(found.width * plan.scale, 1) + "' height='" +
                    fixed(plan.height, 1) + "'/>";
  const double foot = top + plan.height;
  for (const double tick : round_ticks(0.0, 1e3 * found.width, 6))
    if (tick <= 1e3 * found.width + 1e-6)
      svg += "<text class='tick' text-anchor='middle' x='" + fixed(plan({tick / 1e3, 0.0}).x, 1) +
             "' y='" + fixed(foot + 17, 1) + "'>" + fixed(tick, 0) + "</text>";
  for (const double tick : round_ticks(0.0, 1e3 * found.depth, 3))
    if (tick <= 1e3 * found.depth + 1e-6)
      svg += "<text class='tick' text-anchor='end' x='" + fixed(left - 7, 1) + "' y='" +
             fixed(plan({0.0, tick / 1e3}).y + 4, 1) + "'>" + fixed(tick, 0) + "</text>";
  return svg + "<text class='label' text-anchor='middle' x='" +
         fixed(left + found.width * plan.scale / 2, 1) + "' y='" + fixed(foot + 37, 1) +
         "'>x along the wide face, mm</text><text class='label' text-anchor='middle' "
         "transform='translate(14 " +
         fixed(top + plan.height / 2, 1) + ") rotate(-90)'>y, mm</text>";
}

}  // namespace

GapMap draw_gap_map(const v1::Frame& frame) {
  GapMap map;
  if (!has_bottom(frame)) return map;
  const Bottom found = bottom_of(frame);
  if (found.triangles.empty() || !(found.width > 0.0) || !(found.depth > 0.0)) return map;
  double least = 0.0, greatest = 0.0;
  for (int i = 0; i < frame.bottom_node_size(); ++i) {
    const double gap = frame.bottom_gap_m(i);
    least = std::min(least, 1e3 * gap);
    greatest = std::max(greatest, 1e3 * gap);
    if (!(gap > map.largest_gap_m)) continue;
    const Point& at = found.place[static_cast<std::size_t>(frame.bottom_node(i))];
    map.largest_gap_m = gap;
    map.largest_x_m = at.x;
    map.largest_y_m = at.y;
  }
  const ColourBands bands{least, std::max(greatest, least + 1e-3)};
  const double scale = std::min(drawing_width / found.width, drawing_width / found.depth);
  const Plan plan{scale, found.depth * scale};
  map.svg = "<svg class='map' viewBox='0 0 " + fixed(left + found.width * scale + right, 0) + " " +
            fixed(top + plan.height + bottom, 0) +
            "' role='img' aria-label='Gap under the butt in plan'>" + fill(found, plan, bands) +
            lines(found, plan, bands) + axes(found, plan) +
            contacts(frame, found, plan, map.contacts) +
            colour_bar(bands, "mm", left + found.width * scale + 18, top, plan.height) + "</svg>";
  return map;
}

}  // namespace dccast::client::render
