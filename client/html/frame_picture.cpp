#include "client/html/frame_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/core.h>

#include "client/html/svg_chart.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

/// Bounds of a drawing [m].
struct Extent {
  double x0, y0, x1, y1;

  void add(const Point& p) {
    x0 = std::min(x0, p.x);
    x1 = std::max(x1, p.x);
    y0 = std::min(y0, p.y);
    y1 = std::max(y1, p.y);
  }
};

constexpr double section_width = 560, margin_left = 56, margin_top = 24, margin_bottom = 46,
                 margin_right = 100;

void add_section(const v1::Frame& frame, double displacement_scale, Extent& extent) {
  const std::vector<double> coordinates = coordinates_of(frame, displacement_scale);
  for (std::size_t i = 0; i + 1 < coordinates.size(); i += 2)
    extent.add({coordinates[i], coordinates[i + 1]});
}

FramePictures section_picture(const v1::Frame& frame, const ColourBands& bands) {
  const double magnification = displacement_scale(frame);
  Extent still{};  // both with the origin
  add_section(frame, 0.0, still);
  Extent all = still;
  add_section(frame, magnification, all);
  const double scale = section_width / std::max({all.x1 - all.x0, all.y1 - all.y0, 1e-6});
  const auto x = [&](double metres) { return margin_left + (metres - all.x0) * scale; };
  const auto y = [&](double metres) { return margin_top + (all.y1 - metres) * scale; };
  const double right = x(all.x1), foot = y(all.y0);
  std::string svg = fmt::format(
      "<svg class='section' viewBox='0 0 {:.0f} {:.0f}' role='img' aria-label='Deformed section "
      "with isotherms'><g class='now'></g>",
      right + margin_right, foot + margin_bottom);
  for (const double tick : round_ticks(0.0, 1e3 * still.x1, 6))
    if (tick <= 1e3 * all.x1 + 1e-6)
      svg +=
          svg_text("class='tick' text-anchor='middle'", x(tick / 1e3), foot + 18, fixed(tick, 0));
  for (const double tick : round_ticks(0.0, 1e3 * still.y1, 4))
    if (tick <= 1e3 * all.y1 + 1e-6)
      svg += svg_text("class='tick' text-anchor='end'", margin_left - 8, y(tick / 1e3) + 4,
                      fixed(tick, 0));
  svg += svg_text("class='label' text-anchor='middle'", x((all.x0 + all.x1) / 2), foot + 38,
                  "distance from the symmetry plane, mm") +
         svg_name_upwards((margin_top + foot) / 2, "height, mm") +
         colour_bar(bands, "°C", right + 24, margin_top, foot - margin_top) + "</svg>";
  const PictureView view{.across = {scale, 0.0, 0.0, x(0.0)}, .down = {0.0, -scale, 0.0, y(0.0)}};
  return {{{"", svg, view}}, magnification};
}

constexpr double slab_width = 460, slab_height = 330, slab_margin = 12, bar_width = 62;
// Omits faces that are turned away from a side by more than 45 degrees.
constexpr double on_side = 0.7;

/// Parallel projection towards a viewer.
struct Projection {
  Vector3 to_viewer, right, up;

  explicit Projection(const Vector3& direction)
      : to_viewer(unit(direction)),
        right(unit(cross({0.0, 0.0, 1.0}, to_viewer))),
        up(cross(to_viewer, right)) {}
  Point operator()(const Vector3& p) const { return {dot(p, right), dot(p, up)}; }
};

struct NamedSide {
  Vector3 normal;
  const char* name;
};
constexpr NamedSide sides[] = {{{1, 0, 0}, "narrow face"},    {{0, 1, 0}, "wide face"},
                               {{0, 0, -1}, "butt"},          {{0, 0, 1}, "metal level"},
                               {{-1, 0, 0}, "middle, x = 0"}, {{0, -1, 0}, "middle, y = 0"}};

/// Places the projected slab in the view box.
struct Canvas {
  static constexpr double none = std::numeric_limits<double>::infinity();
  Extent extent{none, none, -none, -none};

  double scale() const {
    return std::min((slab_width - 2 * slab_margin) / std::max(extent.x1 - extent.x0, 1e-9),
                    (slab_height - 2 * slab_margin) / std::max(extent.y1 - extent.y0, 1e-9));
  }
  Point operator()(const Point& p) const {
    return {slab_width / 2 + (p.x - (extent.x0 + extent.x1) / 2) * scale(),
            slab_height / 2 - (p.y - (extent.y0 + extent.y1) / 2) * scale()};
  }
};

/// Writes the names of the visible sides in the middle of each.
std::string side_names(const std::vector<SurfaceFace>& surface, const std::vector<Vector3>& place,
                       const Projection& project, const Canvas& canvas) {
  std::string svg = "<g class='sides'>";
  for (const NamedSide& side : sides) {
    if (dot(side.normal, project.to_viewer) < 0.15) continue;
    const auto faces = facing(surface, side.normal, on_side);
    if (faces.empty()) continue;
    Vector3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    for (const SurfaceFace& face : faces)
      for (const int node : face.node)
        for (std::size_t c = 0; c < 3; ++c) {
          low[c] = std::min(low[c], place[node][c]);
          high[c] = std::max(high[c], place[node][c]);
        }
    const Point at =
        canvas(project({(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2}));
    svg += svg_text("class='isotherm-label' text-anchor='middle'", at.x, at.y + 4, side.name);
  }
  return svg + "</g>";
}

/// Maps projected coordinates to those of the canvas.
PictureView view_of(const Projection& project, const Canvas& canvas) {
  const Point origin = canvas({0.0, 0.0});
  const double scale = canvas.scale();
  PictureView view{.to_viewer = project.to_viewer};
  for (std::size_t c = 0; c < 3; ++c) {
    view.across[c] = scale * project.right[c];
    view.down[c] = -scale * project.up[c];
  }
  view.across[3] = origin.x;
  view.down[3] = origin.y;
  return view;
}

FramePictures slab_pictures(const v1::Frame& frame, const ColourBands& bands) {
  FramePictures found{.displacement_scale = displacement_scale(frame)};
  const auto place = places_of(frame, found.displacement_scale), still = places_of(frame, 0.0);
  const auto surface = surface_of(frame);
  for (const auto& [name, direction] :
       {std::pair<const char*, Vector3>{"from outside, above", {1.0, 1.3, 0.7}},
        {"from outside, below", {1.0, 1.3, -0.8}},
        {"from the middle of the slab", {-1.0, -1.3, 0.7}}}) {
    const Projection project(direction);
    Canvas canvas;
    for (const auto* places : {&place, &still})
      for (const SurfaceFace& face : surface)
        for (const int node : face.node) canvas.extent.add(project((*places)[node]));
    const std::string svg = fmt::format(
                                "<svg class='slab' viewBox='0 0 {:.0f} {:.0f}' role='img' "
                                "aria-label='Deformed quarter slab, {}'><g class='now'></g>",
                                slab_width + bar_width, slab_height, name) +
                            side_names(surface, place, project, canvas) +
                            colour_bar(bands, "°C", slab_width + 4, 40, slab_height - 70) +
                            "</svg>";
    found.pictures.push_back({name, svg, view_of(project, canvas)});
  }
  return found;
}

}  // namespace

FramePictures pictures_of(const v1::Frame& frame, const ColourBands& bands) {
  if (is_consistent(frame, 2)) return section_picture(frame, bands);
  if (is_consistent(frame, 3)) return slab_pictures(frame, bands);
  return {};
}

}  // namespace dccast::client::render
