#include "client/html/frame_picture.hpp"

#include <algorithm>
#include <cmath>

#include "client/html/colour_bands.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

constexpr double section_width = 560, margin_left = 56, margin_top = 24, margin_bottom = 46,
                 margin_right = 100;

/// Frame of the drawing: metres to the view box.
struct SectionView {
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

SectionView section_view(const std::vector<Point>& drawn, const std::vector<Point>& still) {
  SectionView view{0.0, 0.0, 0.0, 0.0, 1.0};
  for (const auto* nodes : {&drawn, &still})
    for (const Point& p : *nodes) {
      view.x0 = std::min(view.x0, p.x);
      view.x1 = std::max(view.x1, p.x);
      view.y0 = std::min(view.y0, p.y);
      view.y1 = std::max(view.y1, p.y);
    }
  view.scale = section_width / std::max({view.x1 - view.x0, view.y1 - view.y0, 1e-6});
  return view;
}

std::string axes(const SectionView& view, double width_m, double height_m) {
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

FramePictures section_picture(const v1::Frame& frame, const ColourBands& bands) {
  FramePictures found{.displacement_scale = displacement_scale(frame)};
  const auto still = nodes_of(frame, 0.0);
  const SectionView view = section_view(nodes_of(frame, found.displacement_scale), still);
  double width_m = 0.0, height_m = 0.0;
  for (const Point& p : still) {
    width_m = std::max(width_m, p.x);
    height_m = std::max(height_m, p.y);
  }
  const std::string svg =
      "<svg class='section' viewBox='0 0 " + fixed(view.width(), 0) + " " +
      fixed(view.height(), 0) +
      "' role='img' aria-label='Deformed section with isotherms'><g class='now'></g>" +
      axes(view, width_m, height_m) +
      colour_bar(bands, "°C", view.width() - margin_right + 24, margin_top,
                 view.height() - margin_top - margin_bottom) +
      "</svg>";
  found.pictures.push_back({"",
                            svg,
                            {.across = {view.scale, 0.0, 0.0, view.x(0.0)},
                             .down = {0.0, -view.scale, 0.0, view.y(0.0)}}});
  return found;
}

constexpr double slab_width = 460, slab_height = 330, slab_margin = 12, bar_width = 62;
// Faces that turn away from a side by more than 45 degrees are not on it.
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
  double x0 = 1e300, y0 = 1e300, x1 = -1e300, y1 = -1e300;

  void add(const Point& p) {
    x0 = std::min(x0, p.x);
    x1 = std::max(x1, p.x);
    y0 = std::min(y0, p.y);
    y1 = std::max(y1, p.y);
  }
  double scale() const {
    return std::min((slab_width - 2 * slab_margin) / std::max(x1 - x0, 1e-9),
                    (slab_height - 2 * slab_margin) / std::max(y1 - y0, 1e-9));
  }
  Point operator()(const Point& p) const {
    return {slab_width / 2 + (p.x - (x0 + x1) / 2) * scale(),
            slab_height / 2 - (p.y - (y0 + y1) / 2) * scale()};
  }
};

/// The names of the sides that are seen, in the middle of each.
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
    svg += "<text class='isotherm-label' text-anchor='middle' x='" + fixed(at.x, 1) + "' y='" +
           fixed(at.y + 4, 1) + "'>" + side.name + "</text>";
  }
  return svg + "</g>";
}

/// Where a canvas puts what a projection gives.
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
        for (const int node : face.node) canvas.add(project((*places)[node]));
    const std::string svg =
        "<svg class='slab' viewBox='0 0 " + fixed(slab_width + bar_width, 0) + " " +
        fixed(slab_height, 0) + "' role='img' aria-label='Deformed quarter slab, " + name +
        "'><g class='now'></g>" + side_names(surface, place, project, canvas) +
        colour_bar(bands, "°C", slab_width + 4, 40, slab_height - 70) + "</svg>";
    found.pictures.push_back({name, svg, view_of(project, canvas)});
  }
  return found;
}

}  // namespace

FramePictures pictures_of(const v1::Frame& frame, const ColourRange& range) {
  const ColourBands bands{range.low, range.high};
  if (consistent(frame)) return section_picture(frame, bands);
  if (consistent_3d(frame)) return slab_pictures(frame, bands);
  return {};
}

}  // namespace dccast::client::render
