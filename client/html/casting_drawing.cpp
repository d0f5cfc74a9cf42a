#include "client/html/casting_drawing.hpp"

#include <algorithm>
#include <vector>

#include "client/html/report_style.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/casting_text.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/table.hpp"
#include "proto/frames/contraction.hpp"

namespace dccast::client::render {
namespace {

// Of the view box [px]; the section is to scale, with the metal level at y = 0.
constexpr double width = 1040, height = 560, head = 60;
constexpr double axis_x = 30, wall_x = 380, label_x = 422;  // symmetry plane, mould wall, names
constexpr double level_y = head + 90, lowest_y = height - 50;
constexpr double wall = 26;  // thickness of the mould as drawn [px]

/// Sizes of the start, below the metal level [m].
struct Start {
  double half;   ///< from the symmetry plane to the mould
  double water;  ///< water line, foot of the mould
  double block;  ///< top of the block
  double foot;   ///< of what is shown of the block
  double scale;  ///< [px/m]

  double y(double depth_m) const { return level_y + scale * depth_m; }
};

Start start_of(const v1::Case& c) {
  Start start{.half = c.section().half_width_m(),
              .water = c.cooling().water().from_m(),
              .block = c.section().initial_depth_m(),
              .foot = 0.0,
              .scale = 0.0};
  if (c.section().half_thickness_m().value_size() > 0)
    start.half = c.section().half_thickness_m().value(0);
  if (!c.section().has_initial_depth_m())
    start.block = start.water - c.section().block_above_water_m();
  constexpr double below = 0.12;  // shown below the deeper of the two [m]
  start.foot = std::max(start.water, start.block) + below;
  start.scale = std::min((wall_x - axis_x) / start.half, (lowest_y - level_y) / start.foot);
  return start;
}

std::string box(double x, double y, double wide, double high, const std::string& style) {
  return "<rect x='" + fixed(x, 1) + "' y='" + fixed(y, 1) + "' width='" + fixed(wide, 1) +
         "' height='" + fixed(high, 1) + "' style='" + style + "'/>";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return "<line x1='" + fixed(x1, 1) + "' y1='" + fixed(y1, 1) + "' x2='" + fixed(x2, 1) +
         "' y2='" + fixed(y2, 1) + "' style='" + style + "'/>";
}

std::string text_at(double x, double y, const std::string& text, const std::string& more = {}) {
  return "<text class='label' x='" + fixed(x, 1) + "' y='" + fixed(y, 1) + "'" + more + ">" +
         html_escaped(text) + "</text>";
}

std::string millimetres(double metres) {
  return plant_number(1e3 * metres) + " mm";
}

/// A name beside the mould, and where it points to.
struct Label {
  double y;
  std::string text;
};

/// From top to bottom, none over another.
std::string labels(std::vector<Label> all) {
  constexpr double row = 17;
  std::ranges::stable_sort(all, {}, &Label::y);
  std::string svg;
  double free = 0.0;
  for (const Label& label : all) {
    const double at = std::max(label.y, free);
    free = at + row;
    svg += line(wall_x + wall + 2, label.y, label_x - 4, at, "stroke:var(--zero)") +
           text_at(label_x, at + 4, label.text);
  }
  return svg;
}

std::string section_labels(const v1::Case& c, const Start& start) {
  std::vector<Label> all{{level_y, "metal level"},
                         {start.y(start.water), "water line, " + millimetres(start.water)},
                         {start.y(start.block), "block at the start, " + millimetres(start.block)}};
  for (const v1::SideZone& zone : c.cooling().zone())
    all.push_back(
        {start.y((zone.from_m() + zone.to_m()) / 2.0),
         zone.name() + ", " + millimetres(zone.from_m()) + " to " + millimetres(zone.to_m())});
  return labels(std::move(all));
}

std::string section_part(const v1::Case& c) {
  const Start start = start_of(c);
  const double right = axis_x + start.scale * start.half;
  const double foot = start.y(start.water), block = start.y(start.block), end = start.y(start.foot);
  std::string svg;
  svg += box(axis_x, level_y, right - axis_x, block - level_y, "fill:var(--line-1);opacity:.35");
  svg += box(axis_x, block, right - axis_x - 3, end - block, "fill:var(--zero);opacity:.55");
  svg += box(right, level_y - 25, wall, foot - level_y + 25, "fill:var(--soft);opacity:.7");
  for (const v1::SideZone& zone : c.cooling().zone())
    svg += line(right, start.y(zone.to_m()), right + wall, start.y(zone.to_m()),
                "stroke:var(--card);stroke-width:2");
  // The jet leaves the foot of the mould, and the film runs down face and block.
  svg += line(right + wall, foot - 6, right, foot, "stroke:var(--line-0);stroke-width:3") +
         line(right + 1, foot, right + 1, end, "stroke:var(--line-0);stroke-width:3");
  svg +=
      line(axis_x, level_y - 30, axis_x, end + 8, "stroke:var(--zero);stroke-dasharray:12 4 2 4");
  svg += line(axis_x, level_y, right, level_y, "stroke:var(--line-1);stroke-width:2");
  svg +=
      text_at((axis_x + right) / 2, (level_y + block) / 2 + 4, "metal", " text-anchor='middle'") +
      text_at((axis_x + right) / 2, (block + end) / 2 + 4, "bottom block", " text-anchor='middle'");
  svg += text_at((axis_x + right) / 2, end + 24,
                 millimetres(start.half) + (c.section().kind() == v1::Section::AXISYMMETRIC
                                                ? " to the axis"
                                                : " to the symmetry plane"),
                 " text-anchor='middle'");
  return "<g transform='translate(" + fixed(wall_x - right, 1) + " 0)'>" + svg + "</g>" +
         section_labels(c, start);
}

/// A table of the schedule over the start. @param from_s  when it begins to act
std::string ramp_chart(const std::string& name, const std::string& unit, const v1::Curve& table,
                       double factor, double from_s, double end_s) {
  const bool by_length = table.abscissa() == v1::CAST_LENGTH;
  const double scale = by_length ? 1e3 : 1.0;
  std::vector<double> at(table.at().begin(), table.at().end());
  at.push_back(by_length ? 0.0 : from_s);
  if (!by_length) at.push_back(end_s);
  std::ranges::sort(at);
  ChartLine ramp{name, {}, {}};
  for (const double place : at) {
    ramp.x.push_back(scale * place);
    ramp.y.push_back(factor * frames::curve_value(table, place));
  }
  return svg_chart({name, by_length ? "cast length, mm" : "time, s", name + ", " + unit, {ramp}});
}

/// A chart of its own size inside the drawing.
std::string placed(const std::string& chart, double y) {
  const std::string begin = "<svg ";
  return "<svg x='620' y='" + fixed(y, 0) +
         "' width='410' height='230' style='width:410px;height:230px' " +
         chart.substr(begin.size());
}

}  // namespace

std::string casting_drawing(const v1::Case& c) {
  const v1::Schedule& recipe = c.schedule();
  std::string svg =
      "<?xml version='1.0' encoding='UTF-8'?>\n<svg xmlns='http://www.w3.org/2000/svg' "
      "viewBox='0 0 " +
      fixed(width, 0) + " " + fixed(height, 0) +
      "' font-family='system-ui,\"DejaVu Sans\",sans-serif' role='img' aria-label='" +
      html_escaped(c.title()) + "'><style>" + report_style + "</style>" +
      box(0, 0, width, height, "fill:var(--card)") +
      text_at(20, 26, c.title(), " style='font-size:17px;font-weight:650'") +
      text_at(20, 46, casting_summary(c)) + section_part(c);
  if (recipe.casting_speed_m_per_s().value_size() > 0)
    svg += placed(ramp_chart("casting speed", "mm/min", recipe.casting_speed_m_per_s(), mm_per_min,
                             0.0, c.time().end_s()),
                  70);
  if (recipe.water_flow_m2_per_s().value_size() > 0)
    svg += placed(ramp_chart("water", "l/min/m", recipe.water_flow_m2_per_s(), litres_per_min_per_m,
                             c.cooling().water().start_s(), c.time().end_s()),
                  310);
  return svg + "</svg>\n";
}

}  // namespace dccast::client::render
