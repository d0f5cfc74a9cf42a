#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "client/html/frame_bytes.hpp"
#include "client/html/html_parts.hpp"
#include "client/html/judgement_parts.hpp"
#include "client/html/report_parts.hpp"
#include "client/text/table.hpp"
#include "proto/frames/contraction.hpp"

namespace dccast::client::render {
namespace {

/// "Beyond validity. " before the caption of a frame stored after the model stopped being valid.
std::string frame_mark(const v1::Frame& frame, const CurlHistory& history) {
  const auto first = history.first_beyond();
  const bool valid = !first || frame.time_s() < history.time_s[*first];
  return valid ? "" : "<strong>Beyond validity.</strong> ";
}

/// The frames as report.js reads them; empty if the last one cannot be drawn.
std::optional<Json> slab_json(const FrameSeries& series, const CurlHistory& history) {
  Json json{{"times", Json::array()},
            {"fields", Json::array()},
            {"frames", Json::array()},
            {"values", Json::object()}};
  for (const v1::Frame& frame : series.frames) {
    const auto bytes = frame_bytes(frame, Precision::drawing);
    const bool is_last = &frame == &series.frames.back();
    if (!bytes && is_last) return std::nullopt;
    if (!bytes) continue;
    json["times"].push_back(frame.time_s());
    json["frames"].push_back(packed(*bytes));
  }

  for (const v1::FrameField& field : series.fields) {
    json["fields"].push_back(to_json(field));
    json["values"][field.name()] = packed(float_bytes(field.values(), Precision::drawing));
  }
  if (const auto first = history.first_beyond()) json["beyond_s"] = history.time_s[*first];
  return json;
}

/// A chart without lines, against a distance along the slab. @param quantity  [`unit`]
v1::Chart chart_along(const std::string& distance, const std::string& heading,
                      const std::string& quantity, const std::string& unit) {
  v1::Chart chart;
  chart.set_heading(heading);
  chart.mutable_x()->set_quantity(distance);
  chart.mutable_x()->set_unit("m");
  chart.mutable_y()->set_quantity(quantity);
  chart.mutable_y()->set_unit(unit);
  return chart;
}

void add_point(v1::Chart::Line& line, double x, double y) {
  line.add_x(x);
  line.add_y(y);
}

/// Gap and pressure along the bottom of a section, if their sizes agree.
std::string contact_figures(const v1::Frame& frame, const CurlHistory& history) {
  constexpr const char* distance = "distance from the symmetry plane";
  v1::Chart gaps = chart_along(distance, "Gap along the bottom", "gap", "m");
  v1::Chart pressures = chart_along(distance, "Contact pressure", "pressure", "Pa");
  v1::Chart::Line& gap = *gaps.add_lines();
  v1::Chart::Line& pressure = *pressures.add_lines();
  gap.set_name("gap");
  pressure.set_name("pressure");

  for (int i = 0; i < frame.bottom_node_size(); ++i) {
    const int node = frame.bottom_node(i);
    if (node < 0 || 2 * node + 1 >= frame.node_m_size()) continue;
    if (i < frame.bottom_gap_m_size())
      add_point(gap, frame.node_m(2 * node), frame.bottom_gap_m(i));
    if (i < frame.bottom_pressure_pa_size())
      add_point(pressure, frame.node_m(2 * node), frame.bottom_pressure_pa(i));
  }
  if (gap.x().empty() && pressure.x().empty()) return {};

  const std::string mark = frame_mark(frame, history);
  return chart_figure(gaps, mark + "Distance between slab and bottom block at the last frame.") +
         chart_figure(pressures, mark + "Zero where the slab has lifted off the block.");
}

/// The bottom of a quarter slab, drawn from the frames of the slab; its figures as text.
std::string gap_figure(const v1::Frame& frame, const CurlHistory& history) {
  int largest = -1;
  for (int i = 0; i < std::min(frame.bottom_gap_m_size(), frame.bottom_node_size()); ++i) {
    const int node = frame.bottom_node(i);
    if (node < 0 || 3 * node + 2 >= frame.node_m_size()) return {};
    if (largest < 0 || frame.bottom_gap_m(i) > frame.bottom_gap_m(largest)) largest = i;
  }
  if (largest < 0) return {};

  const int node = frame.bottom_node(largest);
  const auto contacts = std::ranges::count_if(frame.bottom_pressure_pa(),
                                              [](double pressure) { return pressure > 0.0; });
  return figure(
      "Gap under the butt", "<div class='gap-map'></div>",
      frame_mark(frame, history) +
          fmt::format("The bottom seen from below. Largest gap <strong>{} mm</strong> at "
                      "x {} mm, y {} mm from the middle of the slab. In contact with the "
                      "block: {} of {} nodes.",
                      mm(frame.bottom_gap_m(largest)), mm(frame.node_m(3 * node), 0),
                      mm(frame.node_m(3 * node + 1), 0), contacts, frame.bottom_node_size()));
}

/// The highest row of the wide face that is solid with all rows below it. The metal behind the face
/// may be liquid there.
const frames::FaceRow& highest_solid(const frames::Contraction& face, const v1::Section& section,
                                     const v1::Frame& frame) {
  constexpr double same_m = 1e-6;
  double soft_m = std::numeric_limits<double>::infinity();
  for (int n = 0; n < frame.temperature_c_size(); ++n) {
    const double x = frame.node_m(3 * n), y = frame.node_m(3 * n + 1), z = frame.node_m(3 * n + 2);
    const bool on_face = y > frames::half_opening_m(section, x) - same_m;
    if (on_face && frame.temperature_c(n) > frames::shell_c(frame)) soft_m = std::min(soft_m, z);
  }

  const frames::FaceRow* highest = &face.rows.front();
  for (const frames::FaceRow& row : face.rows)
    if (row.height_m < soft_m - same_m) highest = &row;
  return *highest;
}

struct NamedRow {
  std::string name;
  const frames::FaceRow& row;
};

v1::Chart pull_in_chart(const std::vector<NamedRow>& rows) {
  v1::Chart chart = chart_along("distance from the middle of the wide face",
                                "Pull-in of the wide face", "pull-in", "m");
  for (const auto& [name, row] : rows) {
    v1::Chart::Line& line = *chart.add_lines();
    line.set_name(fmt::format("{}, {} mm", name, mm(row.height_m, 0)));
    for (const frames::FacePoint& point : row.points) add_point(line, point.x_m, point.pull_in_m());
  }
  return chart;
}

/// Each row at the middle, half way and at the end of the wide face.
std::string pull_in_table(const std::vector<NamedRow>& rows) {
  std::string head, body;
  for (const char* const text :
       {"", "height, mm", "x, mm", "mould, mm", "slab, mm", "pull-in, mm", "%"})
    head += element("th", text);
  for (const auto& [name, row] : rows) {
    const std::size_t last = row.points.size() - 1;
    for (const std::size_t i : {std::size_t{0}, last / 2, last}) {
      const frames::FacePoint& point = row.points[i];
      std::string cells = element("td", name);
      for (const std::string& text :
           {mm(row.height_m, 0), mm(point.x_m, 0), mm(point.mould_m), mm(point.now_m),
            mm(point.pull_in_m()), fixed(100.0 * point.pull_in_m() / point.mould_m, 1)})
        cells += element("td", text);
      body += element("tr", cells);
    }
  }
  return figures_table(element("tr", head), body);
}

std::string pull_in_figure(const v1::QueryResultResponse& result, const CurlHistory& history) try {
  const frames::Contraction face = frames::contraction_of(result.case_(), result.frame());
  const frames::FaceRow& head = highest_solid(face, result.case_().section(), result.frame());
  const frames::FaceRow& butt = face.at(std::min(frames::butt_height_m, head.height_m));
  std::vector<NamedRow> rows{{"head", head}};
  if (butt.height_m < head.height_m) {
    rows.push_back({"middle", face.at((butt.height_m + head.height_m) / 2.0)});
    rows.push_back({"butt", butt});
  }
  if (head.points.empty()) return {};

  return chart_figure(
      pull_in_chart(rows),
      frame_mark(result.frame(), history) +
          "Half the opening of the mould minus half the thickness of the slab, in % of the former; "
          "negative values are a bulge. Butt: 50 mm above the block; head: the greatest height at "
          "which the whole face is solid; middle: half way. Heights in the undeformed slab." +
          pull_in_table(rows));
} catch (const frames::NoContraction&) {
  return {};
}

}  // namespace

std::string frame_part(const v1::QueryResultResponse& result, const CurlHistory& history,
                       const FrameSeries& series) {
  if (!result.has_frame())
    return card("Slab", "<p>No stored frame: the run has not ended with a result.</p>");
  const v1::Frame& frame = result.frame();
  const FrameSeries shown = series.frames.empty() ? FrameSeries{1, {frame}, {}} : series;
  const auto json = slab_json(shown, history);
  if (!json)
    return card("Slab", "<p>The stored frame cannot be drawn: its arrays are inconsistent.</p>");

  const auto count = static_cast<int>(shown.frames.size());
  return element(
      "section class='card wide slab'",
      drawn("slab", *json) +
          element(
              "div class='caption'",
              fmt::format("{}The last frame is at {} s, cast length {} mm; {} stored frames are in "
                          "this page. Grey lines: before the metal moved. Thin lines: the values "
                          "named below the colours.",
                          frame_mark(frame, history), fixed(frame.time_s(), 1),
                          mm(frame.cast_length_m()),
                          count == shown.stored ? fmt::format("all {}", count)
                                                : fmt::format("{} of {}", count, shown.stored))));
}

std::string bottom_part(const v1::QueryResultResponse& result, const CurlHistory& history) {
  if (!result.has_frame()) return {};
  const v1::Frame& frame = result.frame();
  if (frame.dimension() != 3) return contact_figures(frame, history);
  return gap_figure(frame, history) + pull_in_figure(result, history);
}

}  // namespace dccast::client::render
