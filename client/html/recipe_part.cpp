#include "client/html/recipe_part.hpp"

#include <cmath>

#include "client/html/html_parts.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/plant_units.hpp"

namespace dccast::client::render {
namespace {

bool is_quarter(const v1::Case& input) {
  return input.section().kind() == v1::Section::QUARTER_SLAB;
}

std::string millimetres(double metres) {
  return plant_number(1e3 * metres) + " mm";
}

/// The effect of factor and shift on a table, in words; empty if they have none.
std::string changes(const v1::Curve& factor, double shift_s) {
  std::string text;
  if (factor.value_size() > 1 || (factor.value_size() == 1 && factor.value(0) != 1.0))
    text += "times " + curve_in_words(factor, 1.0, "");
  if (shift_s != 0.0)
    text += (text.empty() ? "" : "; ") + plant_number(std::abs(shift_s)) + " s " +
            (shift_s > 0.0 ? "later" : "earlier");
  return text;
}

std::string size_text(const v1::Section& section) {
  if (section.kind() == v1::Section::QUARTER_SLAB)
    return plant_number(2e3 * section.half_width_m()) + " × " +
           plant_number(2e3 * (section.half_thickness_m().value_size() > 0
                                   ? section.half_thickness_m().value(0)
                                   : 0.0)) +
           " mm";
  return plant_number(2e3 * section.half_width_m()) + " mm " +
         (section.kind() == v1::Section::AXISYMMETRIC ? "in diameter" : "across");
}

const v1::Curve& narrow_flow(const v1::Case& input) {
  const v1::Schedule& recipe = input.schedule();
  return recipe.has_narrow_water_flow_m2_per_s() ? recipe.narrow_water_flow_m2_per_s()
                                                 : recipe.water_flow_m2_per_s();
}

const v1::Water& narrow_water(const v1::Case& input) {
  return input.cooling().has_narrow_water() ? input.cooling().narrow_water()
                                            : input.cooling().water();
}

bool narrow_differs(const v1::Case& input) {
  return is_quarter(input) &&
         (input.schedule().has_narrow_water_flow_m2_per_s() || input.cooling().has_narrow_water());
}

std::string water_note(const v1::Water& water) {
  if (!water.enabled()) return "turned off";
  return "from " + plant_number(water.start_s()) + " s on, " + millimetres(water.from_m()) +
         " below the metal level, at " + curve_in_words(water.temperature_c(), 1.0, "°C");
}

std::string water_rows(const v1::Case& input) {
  const v1::Schedule& recipe = input.schedule();
  const std::string changed = changes(recipe.water_flow_factor(), recipe.water_flow_shift_s());
  const auto one = [&](const std::string& name, const v1::Curve& flow, const v1::Water& water) {
    return row(name, curve_in_words(flow, litres_per_min_per_m, "l/min/m"),
               water_note(water) + (changed.empty() ? "" : "; " + changed));
  };
  if (!narrow_differs(input))
    return one("Water", recipe.water_flow_m2_per_s(), input.cooling().water());
  return one("Water, wide face", recipe.water_flow_m2_per_s(), input.cooling().water()) +
         one("Water, narrow face", narrow_flow(input), narrow_water(input));
}

std::string recipe_table(const v1::Case& input) {
  const v1::Schedule& recipe = input.schedule();
  const v1::BottomBlock& block = input.cooling().bottom_block();
  std::string rows =
      row(input.section().kind() == v1::Section::AXISYMMETRIC ? "Billet" : "Slab",
          size_text(input.section()),
          "metal stands " + millimetres(input.section().initial_depth_m()) + " deep at the start");
  rows += row("Alloy", html_escaped(input.alloy().card()),
              "solidus " + plant_number(input.alloy().solidus_c()) + " °C, liquidus " +
                  plant_number(input.alloy().liquidus_c()) + " °C");
  rows += row("Hold before the block moves", plant_number(recipe.hold_s()) + " s",
              "the shell forms; t = 0 is when the block starts");
  rows += row("Casting speed", curve_in_words(recipe.casting_speed_m_per_s(), mm_per_min, "mm/min"),
              changes(recipe.casting_speed_factor(), recipe.casting_speed_shift_s()));
  rows += row("Casting temperature", curve_in_words(recipe.casting_temperature_c(), 1.0, "°C"));
  rows += water_rows(input);
  rows += row("Bottom block", curve_in_words(block.temperature_c(), 1.0, "°C"));
  return "<table>" + rows + "</table>";
}

bool runs(const v1::Water& water, double time_s) {
  return water.enabled() && time_s >= water.start_s();
}

ChartLine water_line(const v1::QueryResultResponse& result, const std::string& name,
                     const v1::Curve& flow, const v1::Water& water) {
  const v1::Schedule& recipe = result.case_().schedule();
  ChartLine line{name, {}, {}};
  for (const v1::StepReport& step : result.steps()) {
    const double t = step.time_s(), length = step.cast_length_m();
    line.x.push_back(t);
    line.y.push_back(runs(water, t)
                         ? litres_per_min_per_m *
                               curve_value(recipe.water_flow_factor(), t, length, 1.0) *
                               curve_value(flow, t - recipe.water_flow_shift_s(), length, 0.0)
                         : 0.0);
  }
  return line;
}

std::string speed_chart(const v1::QueryResultResponse& result) {
  const v1::Schedule& recipe = result.case_().schedule();
  ChartLine line{"casting speed", {}, {}};
  for (const v1::StepReport& step : result.steps()) {
    const double t = step.time_s(), length = step.cast_length_m();
    line.x.push_back(t);
    // The block does not move during the hold, whatever the table.
    line.y.push_back(t <= 0.0
                         ? 0.0
                         : mm_per_min * curve_value(recipe.casting_speed_factor(), t, length, 1.0) *
                               curve_value(recipe.casting_speed_m_per_s(),
                                           t - recipe.casting_speed_shift_s(), length, 0.0));
  }
  return svg_chart({"Casting speed against time", "time, s", "mm/min", {line}});
}

std::string water_chart(const v1::QueryResultResponse& result) {
  const v1::Case& input = result.case_();
  const bool two = narrow_differs(input);
  std::vector<ChartLine> lines{water_line(result, two ? "wide face" : "water",
                                          input.schedule().water_flow_m2_per_s(),
                                          input.cooling().water())};
  if (two)
    lines.push_back(water_line(result, "narrow face", narrow_flow(input), narrow_water(input)));
  return svg_chart({"Water against time", "time, s", "l/min per metre", lines});
}

}  // namespace

std::string recipe_part(const v1::QueryResultResponse& result) {
  if (!result.has_case_()) return {};
  std::string html = card("Recipe", recipe_table(result.case_()));
  if (result.steps_size() < 2) return html;
  return html +
         figure("Casting speed", speed_chart(result), "As this run had it, factors included.") +
         figure("Water", water_chart(result),
                "Litres a minute on a metre of the slab's perimeter, as this run had it.");
}

}  // namespace dccast::client::render
