#include "client/html/slab_picture.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "client/html/colour_bands.hpp"
#include "client/html/frame_skin.hpp"
#include "client/html/frame_surface.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

constexpr double drawing_width = 460, drawing_height = 330, margin = 12, bar_width = 62;
constexpr double on_side =
    0.7;  // faces that turn away from a side by more than 45 degrees are not on it

/// Parallel projection towards a viewer.
struct Projection {
  Vector3 to_viewer, right, up;

  explicit Projection(const Vector3& direction)
      : to_viewer(unit(direction)),
        right(unit(cross({0.0, 0.0, 1.0}, to_viewer))),
        up(cross(to_viewer, right)) {}
  Point operator()(const Vector3& p) const { return {dot(p, right), dot(p, up)}; }
};

/// What all views of a frame share.
struct Scene {
  std::vector<Vector3> place, still;
  std::vector<double> temperature;
  std::vector<SurfaceFace> surface;
  std::vector<std::array<int, 2>> creases;
  ColourBands bands;
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
    return std::min((drawing_width - 2 * margin) / std::max(x1 - x0, 1e-9),
                    (drawing_height - 2 * margin) / std::max(y1 - y0, 1e-9));
  }
  Point operator()(const Point& p) const {
    return {drawing_width / 2 + (p.x - (x0 + x1) / 2) * scale(),
            drawing_height / 2 - (p.y - (y0 + y1) / 2) * scale()};
  }
};

std::string text_of(const Point& p) {
  return fixed(p.x, 1) + " " + fixed(p.y, 1);
}

/// Outward normal of a face as it is drawn, from that of the undeformed one.
Vector3 drawn_normal(const SurfaceFace& face, const std::vector<Vector3>& place) {
  const auto edge = [&](int a, int b) {
    return Vector3{place[b][0] - place[a][0], place[b][1] - place[a][1], place[b][2] - place[a][2]};
  };
  Vector3 normal =
      unit(cross(edge(face.node[0], face.node[2]), edge(face.node[1], face.node.back())));
  if (dot(normal, face.normal) < 0.0)
    for (double& component : normal) component = -component;
  return normal;
}

Vector3 centre(const SurfaceFace& face, const std::vector<Vector3>& place) {
  Vector3 sum{0.0, 0.0, 0.0};
  for (const int node : face.node)
    for (std::size_t c = 0; c < 3; ++c)
      sum[c] += place[node][c] / static_cast<double>(face.node.size());
  return sum;
}

/// One face in its colours; a band drawn twice in it is one path.
std::string painted(const SurfaceFace& face, const Scene& scene, const Projection& project,
                    const Canvas& canvas) {
  std::map<int, std::string> path;
  for (std::size_t i = 1; i + 1 < face.node.size(); ++i) {
    const std::array<int, 3> corner{face.node[0], face.node[i], face.node[i + 1]};
    std::array<Point, 3> at;
    std::array<double, 3> value;
    for (std::size_t k = 0; k < 3; ++k) {
      at[k] = canvas(project(scene.place[corner[k]]));
      value[k] = scene.temperature[corner[k]];
    }
    for (const BandPiece& piece : band_pieces(at, value, scene.bands))
      for (std::size_t k = 0; k < piece.outline.size(); ++k)
        path[piece.band] += (k == 0 ? "M" : "L") + text_of(piece.outline[k]) +
                            (k + 1 == piece.outline.size() ? "z" : "");
  }
  std::string svg;
  for (const auto& [band, d] : path) {
    const std::string colour = scene.bands.colour(band);
    svg += "<path fill='" + colour + "' stroke='" + colour + "' stroke-width='.5' d='" + d + "'/>";
  }
  return svg;
}

std::string faces_of_view(const Scene& scene, const Projection& project, const Canvas& canvas) {
  std::vector<std::pair<double, const SurfaceFace*>> seen;
  for (const SurfaceFace& face : scene.surface)
    if (dot(drawn_normal(face, scene.place), project.to_viewer) > 0.0)
      seen.push_back({dot(centre(face, scene.place), project.to_viewer), &face});
  std::ranges::stable_sort(seen, {}, &std::pair<double, const SurfaceFace*>::first);
  std::string svg = "<g class='faces'>";
  for (const auto& [depth, face] : seen) svg += painted(*face, scene, project, canvas);
  return svg + "</g>";
}

/// Edges where the surface turns. With a viewer only those that belong to a face he sees.
std::string creases(const Scene& scene, const std::vector<Vector3>& place,
                    const Projection& project, const Canvas& canvas, bool seen_only,
                    const std::string& css_class) {
  std::set<std::pair<int, int>> seen;
  for (const SurfaceFace& face : scene.surface)
    if (!seen_only || dot(drawn_normal(face, place), project.to_viewer) > 0.0)
      for (std::size_t i = 0; i < face.node.size(); ++i)
        seen.insert(std::minmax(face.node[i], face.node[(i + 1) % face.node.size()]));
  std::string path;
  for (const auto& [a, b] : scene.creases)
    if (seen.contains({a, b}))
      path += "M" + text_of(canvas(project(place[a]))) + "L" + text_of(canvas(project(place[b])));
  return "<path class='" + css_class + "' d='" + path + "'/>";
}

/// The names of the sides that are seen, in the middle of each.
std::string side_names(const Scene& scene, const Projection& project, const Canvas& canvas) {
  std::string svg;
  for (const NamedSide& side : sides) {
    if (dot(side.normal, project.to_viewer) < 0.15) continue;
    const auto faces = facing(scene.surface, side.normal, on_side);
    if (faces.empty()) continue;
    Vector3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    for (const SurfaceFace& face : faces)
      for (const int node : face.node)
        for (std::size_t c = 0; c < 3; ++c) {
          low[c] = std::min(low[c], scene.place[node][c]);
          high[c] = std::max(high[c], scene.place[node][c]);
        }
    const Point at =
        canvas(project({(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2}));
    svg += "<text class='isotherm-label' text-anchor='middle' x='" + fixed(at.x, 1) + "' y='" +
           fixed(at.y + 4, 1) + "'>" + side.name + "</text>";
  }
  return svg;
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

SlabPicture::View draw_view(const Scene& scene, const Vector3& direction, const std::string& name) {
  const Projection project(direction);
  Canvas canvas;
  for (const auto* places : {&scene.place, &scene.still})
    for (const SurfaceFace& face : scene.surface)
      for (const int node : face.node) canvas.add(project((*places)[node]));
  const std::string svg =
      "<svg class='slab' viewBox='0 0 " + fixed(drawing_width + bar_width, 0) + " " +
      fixed(drawing_height, 0) + "' role='img' aria-label='Deformed quarter slab, " + name +
      "'><g class='now'>" + faces_of_view(scene, project, canvas) +
      creases(scene, scene.still, project, canvas, false, "undeformed") +
      creases(scene, scene.place, project, canvas, true, "deformed") +
      side_names(scene, project, canvas) + "</g>" +
      colour_bar(scene.bands, "°C", drawing_width + 4, 40, drawing_height - 70) + "</svg>";
  return {name, svg, view_of(project, canvas)};
}

}  // namespace

SlabPicture draw_slab(const v1::Frame& frame, const std::optional<ColourRange>& range) {
  SlabPicture picture;
  if (!consistent_3d(frame)) return picture;
  picture.displacement_scale = displacement_scale(frame);
  Scene scene;
  scene.place = places_of(frame, picture.displacement_scale);
  scene.still = places_of(frame, 0.0);
  scene.temperature.assign(frame.temperature_c().begin(), frame.temperature_c().end());
  scene.surface = surface_of(frame);
  const auto [low, high] = std::ranges::minmax_element(scene.temperature);
  scene.creases = creases_of(scene.surface);
  scene.bands =
      range ? ColourBands{range->low, range->high} : ColourBands{*low, std::max(*high, *low + 1.0)};
  for (const auto& [name, direction] :
       {std::pair<const char*, Vector3>{"from outside, above", {1.0, 1.3, 0.7}},
        {"from outside, below", {1.0, 1.3, -0.8}},
        {"from the middle of the slab", {-1.0, -1.3, 0.7}}})
    picture.views.push_back(draw_view(scene, direction, name));
  return picture;
}

}  // namespace dccast::client::render
