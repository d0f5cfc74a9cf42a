#include <fmt/core.h>

#include "client/html/frame_picture.hpp"
#include "client/html/html_parts.hpp"
#include "client/html/report_parts.hpp"
#include "client/html/slab_charts.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

/// "Beyond validity. " before the caption of a frame stored after the model stopped being valid.
std::string frame_mark(const v1::Frame& frame, const CurlHistory& history) {
  const auto first = history.first_beyond();
  const bool valid = !first || frame.time_s() < history.time_s[*first];
  return valid ? "" : "<strong>Beyond validity.</strong> ";
}

/// The same for a slider, which may show another frame.
std::string moving_mark(const v1::Frame& frame, const CurlHistory& history) {
  return "<span class='beyond-now'>" + frame_mark(frame, history) + "</span>";
}

/// "at 250.0 s, cast length 206.7 mm. Displacements are drawn 2 times as large; dashed:
/// undeformed."
std::string when_and_scale(const v1::Frame& frame, double scale) {
  return fmt::format(
      " at <span class='when'>{}</span>. Displacements are drawn <strong>{}</strong>; dashed: "
      "undeformed.",
      when_text(frame), scale == 1.0 ? "true to scale" : fixed(scale, 0) + " times as large");
}

std::string section_figure(const v1::Frame& frame, const CurlHistory& history,
                           const FramePictures& pictures, const std::string& frames) {
  return figure("Deformed section and isotherms", pictures.pictures.front().svg + frames,
                moving_mark(frame, history) + "Half section" +
                    when_and_scale(frame, pictures.displacement_scale) +
                    fmt::format(" Isotherms every 100 °C; heavy: solidus {} °C, heavy dashed: "
                                "liquidus {} °C. The left edge is the symmetry plane.",
                                fixed(frame.solidus_c(), 0), fixed(frame.liquidus_c(), 0)));
}

/// Position, gap and pressure of the bottom nodes, if their sizes agree.
std::string contact_figures(const v1::Frame& frame, const CurlHistory& history) {
  ChartLine gap{"gap", {}, {}}, pressure{"pressure", {}, {}};
  for (int i = 0; i < frame.bottom_node_size(); ++i) {
    const int node = frame.bottom_node(i);
    if (node < 0 || 2 * node + 1 >= frame.node_m_size()) continue;
    const double x = 1e3 * frame.node_m(2 * node);
    if (i < frame.bottom_gap_m_size()) {
      gap.x.push_back(x);
      gap.y.push_back(1e3 * frame.bottom_gap_m(i));
    }
    if (i < frame.bottom_pressure_pa_size()) {
      pressure.x.push_back(x);
      pressure.y.push_back(1e-3 * frame.bottom_pressure_pa(i));
    }
  }
  if (gap.x.empty() && pressure.x.empty()) return {};
  const std::string mark = frame_mark(frame, history);
  const std::string place = "distance from the symmetry plane, mm";
  return figure("Gap along the bottom",
                svg_chart({"Gap along the bottom", place, "gap, mm", {gap}}),
                mark + "Distance between slab and bottom block at the last frame.") +
         figure(
             "Contact pressure",
             svg_chart({"Contact pressure along the bottom", place, "pressure, kPa", {pressure}}),
             mark + "Zero where the slab has lifted off the block.");
}

std::string slab_figure(const v1::Frame& frame, const CurlHistory& history,
                        const FramePictures& pictures, const std::string& frames) {
  std::string views;
  for (const Picture& picture : pictures.pictures)
    views += "<div><h3>" + picture.name + "</h3>" + picture.svg + "</div>";
  return "<section class='card wide'><h2>Deformed quarter slab</h2><figure><div class='views'>" +
         views + "</div>" + frames + "<figcaption>" + moving_mark(frame, history) +
         "Surface temperature" + when_and_scale(frame, pictures.displacement_scale) +
         " x runs along the wide face, y across the thickness, z up.</figcaption></figure>"
         "</section>";
}

std::string gap_figure(const v1::Frame& frame, const CurlHistory& history) {
  const GapMap map = draw_gap_map(frame);
  if (map.svg.empty()) return {};
  return figure(
      "Gap under the butt", map.svg,
      frame_mark(frame, history) +
          fmt::format("Bottom of the quarter in plan, the middle of the slab at the lower left. "
                      "Largest gap <strong>{} mm</strong> at x {} mm, y {} mm. White dots: in "
                      "contact, {} of {} nodes; larger dots mean higher pressure.",
                      mm(map.largest_gap_m), mm(map.largest_x_m, 0), mm(map.largest_y_m, 0),
                      map.contacts, frame.bottom_node_size()));
}

std::string pull_in_figure(const v1::Frame& frame, const CurlHistory& history) {
  const auto profiles = pull_in_profiles(frame);
  if (profiles.empty()) return {};
  return figure(
      "Pull-in of the wide face", pull_in_chart(profiles) + pull_in_table(profiles),
      frame_mark(frame, history) +
          "Half the opening of the mould minus half the thickness of the slab, in % of the former; "
          "negative values are a bulge. Butt: 50 mm above the block; head: the greatest height "
          "at which the whole face is solid; middle: half way. Heights in the undeformed "
          "slab.");
}

}  // namespace

std::string frame_part(const v1::QueryResultResponse& result, const CurlHistory& history,
                       const FrameSeries& series) {
  if (!result.has_frame())
    return card("Last frame", "<p>No stored frame: the run has not ended with a result.</p>");
  const v1::Frame& frame = result.frame();
  const FrameSeries shown = series.frames.empty() ? FrameSeries{1, {frame}} : series;
  const FramePictures pictures = pictures_of(frame, colour_range(shown).value_or(ColourBands{}));
  const std::string frames = drawn_frames(shown, history, pictures);
  const bool is_slab = frame.dimension() == 3;
  if (pictures.pictures.empty() || frames.empty())
    return card(is_slab ? "Quarter slab" : "Section",
                "<p>The stored frame cannot be drawn: its arrays are inconsistent.</p>");
  return (is_slab ? slab_figure : section_figure)(frame, history, pictures, frames);
}

std::string bottom_part(const v1::QueryResultResponse& result, const CurlHistory& history) {
  if (!result.has_frame()) return {};
  const v1::Frame& frame = result.frame();
  if (frame.dimension() != 3) return contact_figures(frame, history);
  return gap_figure(frame, history) + pull_in_figure(frame, history);
}

}  // namespace dccast::client::render
