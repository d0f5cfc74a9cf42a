#include <algorithm>

#include <fmt/core.h>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/table.hpp"
#include "proto/frames/contraction.hpp"

namespace dccast::client::render {
namespace {

// Sizes in the view box [px]; the section is to scale, with the metal level at y = 0.
constexpr double width = 1040, height = 560, head = 60;
constexpr double axis_x = 30, wall_x = 380, label_x = 422;  // symmetry plane, mould wall, names
constexpr double level_y = head + 90, lowest_y = height - 50;
constexpr double wall = 26;  // thickness of the mould as drawn [px]

/// Depths at the start, below the metal level [m].
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
  return fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' style='{}'/>", x,
                     y, wide, high, style);
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return fmt::format("<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' style='{}'/>", x1, y1,
                     x2, y2, style);
}

std::string text_at(double x, double y, const std::string& text, const std::string& more = {}) {
  return fmt::format("<text class='label' x='{:.1f}' y='{:.1f}'{}>{}</text>", x, y, more,
                     html_escaped(text));
}

/// A label beside the mould and the point that it refers to.
struct Label {
  double y;
  std::string text;
};

/// Places the labels from top to bottom without overlap.
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
                         {start.y(start.water), "water line, " + plant_mm(start.water)},
                         {start.y(start.block), "block at the start, " + plant_mm(start.block)}};
  for (const v1::SideZone& zone : c.cooling().zone())
    all.push_back({start.y((zone.from_m() + zone.to_m()) / 2.0),
                   zone.name() + ", " + plant_mm(zone.from_m()) + " to " + plant_mm(zone.to_m())});
  return labels(std::move(all));
}

std::string section_part(const v1::Case& c) {
  const Start start = start_of(c);
  const double right = axis_x + start.scale * start.half;
  const double foot = start.y(start.water), block = start.y(start.block), end = start.y(start.foot);
  const double middle = (axis_x + right) / 2;
  const auto centred = [&](double y, const std::string& text) {
    return text_at(middle, y, text, " text-anchor='middle'");
  };
  std::string svg =
      box(axis_x, level_y, right - axis_x, block - level_y, "fill:var(--line-1);opacity:.35") +
      box(axis_x, block, right - axis_x - 3, end - block, "fill:var(--zero);opacity:.55") +
      box(right, level_y - 25, wall, foot - level_y + 25, "fill:var(--soft);opacity:.7");
  for (const v1::SideZone& zone : c.cooling().zone())
    svg += line(right, start.y(zone.to_m()), right + wall, start.y(zone.to_m()),
                "stroke:var(--card);stroke-width:2");
  // The jet leaves the foot of the mould, and the film runs down face and block.
  svg +=
      line(right + wall, foot - 6, right, foot, "stroke:var(--line-0);stroke-width:3") +
      line(right + 1, foot, right + 1, end, "stroke:var(--line-0);stroke-width:3") +
      line(axis_x, level_y - 30, axis_x, end + 8, "stroke:var(--zero);stroke-dasharray:12 4 2 4") +
      line(axis_x, level_y, right, level_y, "stroke:var(--line-1);stroke-width:2") +
      centred((level_y + block) / 2 + 4, "metal") + centred((block + end) / 2 + 4, "bottom block") +
      centred(end + 24, plant_mm(start.half) + (c.section().kind() == v1::Section::AXISYMMETRIC
                                                    ? " to the axis"
                                                    : " to the symmetry plane"));
  return fmt::format("<g transform='translate({:.1f} 0)'>{}</g>", wall_x - right, svg) +
         section_labels(c, start);
}

/// Draws a table of the schedule over the start. @param from_s  time at which it takes effect
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

}  // namespace

std::string casting_drawing(const v1::Case& c) {
  const v1::Schedule& recipe = c.schedule();
  std::string svg = box(0, 0, width, height, "fill:var(--card)") +
                    text_at(20, 26, c.title(), " style='font-size:17px;font-weight:650'") +
                    text_at(20, 46, casting_summary(c)) + section_part(c);
  // A chart with its own size inside the drawing.
  const auto add_chart = [&](const std::string& name, const std::string& unit,
                             const v1::Curve& table, double factor, double from_s, double y) {
    if (table.value().empty()) return;
    const std::string begin = "<svg ";
    svg += fmt::format(
               "<svg x='620' y='{:.0f}' width='410' height='230' style='width:410px;height:230px' ",
               y) +
           ramp_chart(name, unit, table, factor, from_s, c.time().end_s()).substr(begin.size());
  };
  add_chart("casting speed", "mm/min", recipe.casting_speed_m_per_s(), mm_per_min, 0.0, 70);
  add_chart("water", "l/min/m", recipe.water_flow_m2_per_s(), litres_per_min_per_m,
            c.cooling().water().start_s(), 310);
  return svg_file(
      fmt::format("viewBox='0 0 {:.0f} {:.0f}' font-family='system-ui,\"DejaVu Sans\",sans-serif' "
                  "role='img' aria-label='{}'",
                  width, height, html_escaped(c.title())),
      svg);
}

}  // namespace dccast::client::render
