#include "client/html/pull_in.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "client/html/frame_surface.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/table.hpp"
#include "proto/frames/contraction.hpp"

namespace dccast::client::render {
namespace {

/// A place on the wide face.
struct Station {
  double x, mould, displacement;  ///< [m]
};

using Triangles = std::vector<std::array<int, 3>>;

/// The faces that look along y, as triangles; the opening of a mould turns them by little.
Triangles wide_face(const v1::Frame& frame) {
  Triangles triangles;
  for (const SurfaceFace& face : facing(surface_of(frame), {0.0, 1.0, 0.0}, 0.7))
    for (std::size_t i = 1; i + 1 < face.node.size(); ++i)
      triangles.push_back({face.node[0], face.node[i], face.node[i + 1]});
  return triangles;
}

/// Where the edge between two nodes passes the height.
Station crossing(const v1::Frame& frame, int a, int b, double height) {
  const auto of = [&](int node, int c) { return frame.node_m(3 * node + c); };
  const double part = (height - of(a, 2)) / (of(b, 2) - of(a, 2));
  const auto between = [&](double from, double to) { return from + part * (to - from); };
  return {between(of(a, 0), of(b, 0)), between(of(a, 1), of(b, 1)),
          between(frame.displacement_m(3 * a + 1), frame.displacement_m(3 * b + 1))};
}

/// The wide face at a height, by x; nodes at this height count as below it.
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

/// Lowest height of the wide face, and its greatest height below all metal that is not yet solid.
std::pair<double, double> solid_range(const v1::Frame& frame, const Triangles& face) {
  double low = std::numeric_limits<double>::infinity(), top = -low, soft = low;
  for (const auto& t : face)
    for (const int node : t) {
      const double z = frame.node_m(3 * node + 2);
      low = std::min(low, z);
      top = std::max(top, z);
      if (frame.temperature_c(node) > frames::shell_c(frame)) soft = std::min(soft, z);
    }
  double head = low;
  for (const auto& t : face)
    for (const int node : t)
      if (const double z = frame.node_m(3 * node + 2); z < soft) head = std::max(head, z);
  return {low, head > low ? head : top};
}

std::string cells(const PullIn& p) {
  const std::size_t last = p.x_m.size() - 1,
                    half = static_cast<std::size_t>(
                        std::ranges::lower_bound(p.x_m, p.x_m.back() / 2) - p.x_m.begin());
  std::string html;
  for (const std::size_t i : {std::size_t{0}, std::min(half, last), last})
    html += "<td>" + fixed(1e3 * p.half_thickness_m[i], 1) + "</td><td>" +
            fixed(1e3 * p.pull_in_m(i), 1) + "</td><td>" + fixed(p.percent(i), 1) + "</td>";
  return html;
}

}  // namespace

std::vector<PullIn> pull_in_profiles(const v1::Frame& frame) {
  if (!consistent_3d(frame) || frame.displacement_m_size() != frame.node_m_size()) return {};
  const Triangles face = wide_face(frame);
  if (face.empty()) return {};
  const auto [lowest, high] = solid_range(frame, face);
  if (!(high > lowest)) return {};
  const double low = std::clamp(frames::butt_height_m, lowest, high);
  //     // At the height of the topmost node no edge would be cut: use a height just below it.
  const double head = high - 1e-9 * (high - low);
  std::vector<PullIn> profiles{profile_at(frame, face, head, "head"),
                               profile_at(frame, face, (low + high) / 2, "middle"),
                               profile_at(frame, face, low, "butt")};
  if (low == high) profiles.resize(1);  // all below the butt: one profile
  std::erase_if(profiles, [](const PullIn& p) { return p.x_m.size() < 2; });
  return profiles;
}

std::string pull_in_chart(const std::vector<PullIn>& profiles) {
  Chart chart;
  chart.title = "Pull-in along the wide face";
  chart.x_label = "distance from the middle of the wide face, mm";
  chart.y_label = "pull-in, mm";
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
    rows += "<tr><td>" + p.name + "</td><td>" + fixed(1e3 * p.height_m, 0) + "</td><td>" +
            fixed(1e3 * p.mould_m.front(), 1) + "</td>" + cells(p) + "</tr>";
  return "<div class='scroll'><table class='figures pull-in'><thead><tr><th rowspan='2'></th>"
         "<th rowspan='2'>height, mm</th><th rowspan='2'>mould, mm</th>"
         "<th colspan='3'>middle of the face</th><th colspan='3'>half way</th>"
         "<th colspan='3'>end of the face</th></tr><tr>"
         "<th>slab, mm</th><th>mm</th><th>%</th><th>slab, mm</th><th>mm</th><th>%</th>"
         "<th>slab, mm</th><th>mm</th><th>%</th></tr></thead><tbody>" +
         rows + "</tbody></table></div>";
}

}  // namespace dccast::client::render
