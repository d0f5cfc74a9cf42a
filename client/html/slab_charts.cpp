#include "client/html/slab_charts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <fmt/core.h>

#include "client/html/colour_bands.hpp"
#include "client/html/frame_surface.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/table.hpp"
#include "proto/frames/contraction.hpp"

namespace dccast::client::render {
namespace {

constexpr double drawing_width = 520, left = 58, top = 26, bottom = 46, right = 74;

/// Bottom of a frame: triangles in plan with their gap.
struct Bottom {
  std::vector<Point> place;    ///< by node [m]
  std::vector<double> gap_mm;  ///< by node; only that of bottom nodes counts
  std::vector<std::array<int, 3>> triangles;
  double width = 0.0, depth = 0.0;  ///< [m]
};

bool has_bottom(const v1::Frame& frame) {
  return is_consistent(frame, 3) && frame.bottom_node_size() > 2 &&
         frame.bottom_gap_m_size() == frame.bottom_node_size() &&
         std::ranges::all_of(frame.bottom_node(), [&](int node) {
           return node >= 0 && node < frame.temperature_c_size();
         });
}

Bottom bottom_of(const v1::Frame& frame) {
  Bottom found;
  for (const Vector3& p : places_of(frame, 0.0)) found.place.push_back({p[0], p[1]});
  found.gap_mm.resize(found.place.size());
  for (int i = 0; i < frame.bottom_node_size(); ++i) {
    const auto node = static_cast<std::size_t>(frame.bottom_node(i));
    found.gap_mm[node] = 1e3 * frame.bottom_gap_m(i);
    found.width = std::max(found.width, found.place[node].x);
    found.depth = std::max(found.depth, found.place[node].y);
  }
  const std::set<int> nodes(frame.bottom_node().begin(), frame.bottom_node().end());
  for (const SurfaceFace& face : facing(surface_of(frame), {0.0, 0.0, -1.0}, 0.5))
    if (std::ranges::all_of(face.node, [&](int node) { return nodes.contains(node); }))
      add_triangles(face.node, found.triangles);
  return found;
}

/// Maps metres in plan to the view box.
struct Plan {
  double scale, height;
  Point operator()(const Point& p) const {
    return {left + p.x * scale, top + height - p.y * scale};
  }
};

std::string text_of(const Point& p) {
  return fmt::format("{:.1f} {:.1f}", p.x, p.y);
}

std::string fill(const Bottom& found, const Plan& plan, const ColourBands& bands) {
  std::map<int, std::string> path;
  for (const auto& t : found.triangles)
    for (const BandPiece& piece :
         band_pieces({plan(found.place[t[0]]), plan(found.place[t[1]]), plan(found.place[t[2]])},
                     {found.gap_mm[t[0]], found.gap_mm[t[1]], found.gap_mm[t[2]]}, bands)) {
      const char* pen = "M";
      for (const Point& p : piece.outline) path[piece.band] += std::exchange(pen, "L") + text_of(p);
      path[piece.band] += "z";
    }
  std::string svg;
  for (const auto& [band, d] : path)
    svg += fmt::format("<path fill='{0}' stroke='{0}' stroke-width='.5' d='{1}'/>",
                       bands.colour(band), d);
  return svg;
}

/// Lines of equal gap at the round values of the colour bar.
std::string lines(const Bottom& found, const Plan& plan, const ColourBands& bands) {
  std::string svg;
  for (const double level : round_ticks(bands.low, bands.high, 5)) {
    if (level <= bands.low || level >= bands.high) continue;
    std::string path;
    for (const Segment& s : isotherm(found.place, found.gap_mm, found.triangles, level))
      path += "M" + text_of(plan(s[0])) + "L" + text_of(plan(s[1]));
    svg +=
        fmt::format("<path class='isotherm' d='{}'><title>{:.1f} mm</title></path>", path, level);
  }
  return svg;
}

/// Dots at the nodes that press on the block, with an area proportional to the pressure.
std::string contacts(const v1::Frame& frame, const Bottom& found, const Plan& plan, int& count) {
  double greatest = 0.0;
  for (const double pressure : frame.bottom_pressure_pa()) greatest = std::max(greatest, pressure);
  std::string svg;
  for (int i = 0; i < std::min(frame.bottom_pressure_pa_size(), frame.bottom_node_size()); ++i) {
    const double pressure = frame.bottom_pressure_pa(i);
    if (!(pressure > 0.0)) continue;
    ++count;
    const Point at = plan(found.place[static_cast<std::size_t>(frame.bottom_node(i))]);
    svg += fmt::format(
        "<circle class='contact' cx='{:.1f}' cy='{:.1f}' r='{:.1f}'><title>{:.1f} "
        "kPa</title></circle>",
        at.x, at.y, 3.0 + 4.0 * std::sqrt(pressure / greatest), 1e-3 * pressure);
  }
  return svg;
}

std::string axes(const Bottom& found, const Plan& plan) {
  const double wide = found.width * plan.scale, foot = top + plan.height;
  std::string svg = svg_box("class='deformed'", left, top, wide, plan.height);
  for (const double tick : round_ticks(0.0, 1e3 * found.width, 6))
    if (tick <= 1e3 * found.width + 1e-6)
      svg += svg_text("class='tick' text-anchor='middle'", plan({tick / 1e3, 0.0}).x, foot + 17,
                      fixed(tick, 0));
  for (const double tick : round_ticks(0.0, 1e3 * found.depth, 3))
    if (tick <= 1e3 * found.depth + 1e-6)
      svg += svg_text("class='tick' text-anchor='end'", left - 7, plan({0.0, tick / 1e3}).y + 4,
                      fixed(tick, 0));
  return svg +
         svg_text("class='label' text-anchor='middle'", left + wide / 2, foot + 37,
                  "x along the wide face, mm") +
         svg_name_upwards(top + plan.height / 2, "y, mm");
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
  map.svg = fmt::format(
                "<svg class='map' viewBox='0 0 {:.0f} {:.0f}' role='img' aria-label='Gap under the "
                "butt in plan'>",
                left + found.width * scale + right, top + plan.height + bottom) +
            fill(found, plan, bands) + lines(found, plan, bands) + axes(found, plan) +
            contacts(frame, found, plan, map.contacts) +
            colour_bar(bands, "mm", left + found.width * scale + 18, top, plan.height) + "</svg>";
  return map;
}

namespace {

/// A point of the wide face.
struct Station {
  double x, mould, displacement;  ///< [m]
};

using Triangles = std::vector<std::array<int, 3>>;

/// Triangles of the faces whose normal is along y; the facets of a mould opening deviate little.
Triangles wide_face(const v1::Frame& frame) {
  Triangles triangles;
  for (const SurfaceFace& face : facing(surface_of(frame), {0.0, 1.0, 0.0}, 0.7))
    add_triangles(face.node, triangles);
  return triangles;
}

/// Point at which the edge between two nodes crosses the height.
Station crossing(const v1::Frame& frame, int a, int b, double height) {
  const auto of = [&](int node, int c) { return frame.node_m(3 * node + c); };
  const double part = (height - of(a, 2)) / (of(b, 2) - of(a, 2));
  const auto between = [&](double from, double to) { return from + part * (to - from); };
  return {between(of(a, 0), of(b, 0)), between(of(a, 1), of(b, 1)),
          between(frame.displacement_m(3 * a + 1), frame.displacement_m(3 * b + 1))};
}

/// The wide face at a height, by x. Nodes at exactly this height count as below it.
PullIn profile_at(const v1::Frame& frame, const Triangles& face, double height, std::string name) {
  std::vector<Station> stations;
  const auto below = [&](int node) { return frame.node_m(3 * node + 2) <= height; };
  for (const auto& t : face)
    for (std::size_t i = 0; i < 3; ++i)
      if (const int a = t[i], b = t[(i + 1) % 3]; below(a) != below(b))
        stations.push_back(crossing(frame, a, b, height));
  std::ranges::sort(stations, {}, &Station::x);
  PullIn profile{std::move(name), height, {}, {}, {}};
  constexpr double same_m = 1e-7;
  for (const Station& s : stations) {
    if (!profile.x_m.empty() && s.x - profile.x_m.back() < same_m) continue;
    profile.x_m.push_back(s.x);
    profile.mould_m.push_back(s.mould);
    profile.half_thickness_m.push_back(s.mould + s.displacement);
  }
  return profile;
}

/// Lowest height of the wide face, and the greatest height below which all metal is solid.
std::pair<double, double> solid_range(const v1::Frame& frame, const Triangles& face) {
  double low = std::numeric_limits<double>::infinity(), high = -low, soft = low;
  for (const auto& t : face)
    for (const int node : t) {
      const double z = frame.node_m(3 * node + 2);
      low = std::min(low, z);
      high = std::max(high, z);
      if (frame.temperature_c(node) > frames::shell_c(frame)) soft = std::min(soft, z);
    }
  double head = low;
  for (const auto& t : face)
    for (const int node : t)
      if (const double z = frame.node_m(3 * node + 2); z < soft) head = std::max(head, z);
  return {low, head > low ? head : high};
}

std::string cells(const PullIn& p) {
  const std::size_t last = p.x_m.size() - 1,
                    half = static_cast<std::size_t>(
                        std::ranges::lower_bound(p.x_m, p.x_m.back() / 2) - p.x_m.begin());
  std::string html;
  for (const std::size_t i : {std::size_t{0}, std::min(half, last), last})
    html += fmt::format("<td>{:.1f}</td><td>{:.1f}</td><td>{:.1f}</td>",
                        1e3 * p.half_thickness_m[i], 1e3 * p.pull_in_m(i), p.percent(i));
  return html;
}

}  // namespace

std::vector<PullIn> pull_in_profiles(const v1::Frame& frame) {
  if (!is_consistent(frame, 3) || frame.displacement_m_size() != frame.node_m_size()) return {};
  const Triangles face = wide_face(frame);
  if (face.empty()) return {};
  const auto [lowest, high] = solid_range(frame, face);
  if (!(high > lowest)) return {};
  const double low = std::clamp(frames::butt_height_m, lowest, high);
  // At the height of the topmost node no edge would be cut: use a height just below it.
  const double head = high - 1e-9 * (high - low);
  std::vector<PullIn> profiles{profile_at(frame, face, head, "head"),
                               profile_at(frame, face, (low + high) / 2, "middle"),
                               profile_at(frame, face, low, "butt")};
  if (low == high) profiles.resize(1);  // all below the butt: one profile
  std::erase_if(profiles, [](const PullIn& p) { return p.x_m.size() < 2; });
  return profiles;
}

std::string pull_in_chart(const std::vector<PullIn>& profiles) {
  Chart chart{"Pull-in along the wide face",
              "distance from the middle of the wide face, mm",
              "pull-in, mm",
              {}};
  for (const PullIn& p : profiles) {
    ChartLine line{p.name + ", " + fixed(1e3 * p.height_m, 0) + " mm", {}, {}};
    for (std::size_t i = 0; i < p.x_m.size(); ++i) {
      line.x.push_back(1e3 * p.x_m[i]);
      line.y.push_back(1e3 * p.pull_in_m(i));
    }
    chart.lines.push_back(std::move(line));
  }
  return svg_chart(chart);
}

std::string pull_in_table(const std::vector<PullIn>& profiles) {
  if (profiles.empty()) return {};
  std::string rows;
  for (const PullIn& p : profiles)
    rows += fmt::format("<tr><td>{}</td><td>{:.0f}</td><td>{:.1f}</td>{}</tr>", p.name,
                        1e3 * p.height_m, 1e3 * p.mould_m.front(), cells(p));
  return "<div class='scroll'><table class='figures pull-in'><thead><tr><th rowspan='2'></th>"
         "<th rowspan='2'>height, mm</th><th rowspan='2'>mould, mm</th>"
         "<th colspan='3'>middle of the face</th><th colspan='3'>half way</th>"
         "<th colspan='3'>end of the face</th></tr><tr>"
         "<th>slab, mm</th><th>mm</th><th>%</th><th>slab, mm</th><th>mm</th><th>%</th>"
         "<th>slab, mm</th><th>mm</th><th>%</th></tr></thead><tbody>" +
         rows + "</tbody></table></div>";
}

}  // namespace dccast::client::render
