// What a run had and how sound it is, as tables of facts: name, value, remark.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/schedule.hpp"
#include "server/judging/judgement.hpp"
#include "server/judging/run_judgement.hpp"

namespace dccast::judging {
namespace {

using case_file::curve_in_words, case_file::Face, case_file::plant_mm, case_file::plant_number;
using Step = v1::StepReport;

v1::Table& add_facts(v1::Judgement& judgement, const std::string& key, const std::string& heading) {
  v1::Table& table = add_table(judgement, key, heading, v1::JudgementPart::PAGE);
  for (const char* const column : {"name", "value", "remark"})
    add_columns(table, {text_column(column, column)});
  return table;
}

void add_fact(v1::Table& table, const std::string& name, const std::string& value,
              const std::string& remark = {}) {
  add_row(table, {text_cell(name), text_cell(value), text_cell(remark)});
}

bool is_quarter(const v1::Case& input) {
  return input.section().kind() == v1::Section::QUARTER_SLAB;
}

/// Describes factor and shift of a table; empty if they have no effect.
std::string changes_in_words(const v1::Curve& factor, double shift_s) {
  std::string text;
  if (factor.value_size() > 1 || (factor.value_size() == 1 && factor.value(0) != 1.0))
    text = fmt::format("times {}", curve_in_words(factor, 1.0, ""));
  if (shift_s != 0.0)
    text += fmt::format("{}{} s {}", text.empty() ? "" : "; ", plant_number(std::abs(shift_s)),
                        shift_s > 0.0 ? "later" : "earlier");
  return text;
}

std::string size_text(const v1::Section& section) {
  const std::string width = plant_number(2e3 * section.half_width_m());
  if (section.kind() == v1::Section::AXISYMMETRIC) return width + " mm in diameter";
  if (section.kind() != v1::Section::QUARTER_SLAB) return width + " mm across";
  const auto& half_thickness_m = section.half_thickness_m().value();
  return fmt::format("{} × {}", width,
                     plant_mm(half_thickness_m.empty() ? 0.0 : 2.0 * half_thickness_m[0]));
}

std::string water_note(const v1::Water& water) {
  if (!water.enabled()) return "turned off";
  const std::string gas = changes_in_words(water.critical_heat_flux_factor(), 0.0);
  return fmt::format("from {} s on, {} below the metal level, at {}{}",
                     plant_number(water.start_s()), plant_mm(water.from_m()),
                     curve_in_words(water.temperature_c(), 1.0, "°C"),
                     gas.empty() ? "" : "; critical heat flux " + gas);
}

/// The water of both faces, in one row where they have the same.
void add_water_facts(const v1::Case& input, v1::Table& table) {
  const case_file::CastingSchedule plan(input);
  const auto add = [&](const std::string& name, Face face) {
    const auto [flow, factor, shift_s] = plan.water_flow(face);
    const std::string changed = changes_in_words(factor, shift_s);
    add_fact(table, name, curve_in_words(flow, case_file::litres_per_min_per_m, "l/min/m"),
             water_note(plan.water(face)) + (changed.empty() ? "" : "; " + changed));
  };

  add(plan.has_narrow_water() ? "Water, wide face" : "Water", Face::wide);
  if (plan.has_narrow_water()) add("Water, narrow face", Face::narrow);
  if (!plan.has_second_water()) return;
  const v1::SecondWater& second = input.cooling().second_water();
  add_fact(table, "Second water",
           curve_in_words(input.schedule().second_water_flow_m2_per_s(),
                          case_file::litres_per_min_per_m, "l/min/m"),
           fmt::format("from {} s on, {} below the metal level", plant_number(second.start_s()),
                       plant_mm(second.from_m())));
}

std::string scientific(double value) {
  if (!std::isfinite(value)) return "-";
  return value == 0.0 ? "0" : fmt::format("{:.2e}", value);
}

/// The largest value of a check in all steps.
std::string worst(const JudgedRun& run, double (Step::*figure)() const) {
  double largest = 0.0;
  for (const Step& step : run.steps) largest = std::max(largest, std::abs((step.*figure)()));
  return scientific(largest);
}

std::string element_remark(v1::ElementKind element) {
  if (element == v1::P1) return "linear triangles lock on coarse meshes: compare with q1_bending";
  return element == v1::Q1 ? "long cells resist bending: compare with q1_bending" : "";
}

std::string element_name(v1::ElementKind element) {
  return element == v1::P1 ? "p1" : element == v1::Q1 ? "q1" : "q1_bending";
}

std::string coherency_text(const v1::Alloy& alloy) {
  if (alloy.has_coherency_solid_fraction())
    return fmt::format("solid fraction {:.2f}", alloy.coherency_solid_fraction());
  return fmt::format("{:.0f} °C",
                     alloy.has_coherency_c() ? alloy.coherency_c() : alloy.liquidus_c());
}

}  // namespace

void add_recipe(const v1::Case& input, const std::string& heading, v1::Judgement& judgement) {
  const v1::Schedule& recipe = input.schedule();
  const v1::Section& section = input.section();
  const auto celsius = [](const v1::Curve& curve) { return curve_in_words(curve, 1.0, "°C"); };

  v1::Table& table = add_facts(judgement, "recipe", heading);
  add_fact(table, section.kind() == v1::Section::AXISYMMETRIC ? "Billet" : "Slab",
           size_text(section),
           fmt::format("metal stands {} deep at the start", plant_mm(section.initial_depth_m())));
  add_fact(table, "Alloy", input.alloy().card(),
           fmt::format("solidus {} °C, liquidus {} °C", plant_number(input.alloy().solidus_c()),
                       plant_number(input.alloy().liquidus_c())));
  add_fact(table, "Hold before the block moves", plant_number(recipe.hold_s()) + " s",
           "the shell forms; t = 0 is when the block starts");
  add_fact(table, "Casting speed",
           curve_in_words(recipe.casting_speed_m_per_s(), case_file::mm_per_min, "mm/min"),
           changes_in_words(recipe.casting_speed_factor(), recipe.casting_speed_shift_s()));
  add_fact(table, "Casting temperature", celsius(recipe.casting_temperature_c()));
  if (recipe.has_metal_level_m())
    add_fact(table, "Metal level", curve_in_words(recipe.metal_level_m(), 1e3, "mm"),
             "above that of the start");
  add_water_facts(input, table);
  add_fact(table, "Bottom block", celsius(input.cooling().bottom_block().temperature_c()));
}

void add_checks(const JudgedRun& run, bool is_beyond, v1::Judgement& judgement) {
  constexpr const char* largest = "largest of all steps, relative";
  v1::Table& table = add_facts(judgement, "checks", "checks of the run");
  add_fact(table, "Equilibrium residual", worst(run, &Step::equilibrium_residual), largest);
  add_fact(table, "Energy balance", worst(run, &Step::energy_balance_error), largest);
  add_fact(table, "Complementarity", worst(run, &Step::complementarity_error),
           "gap times pressure, relative");
  add_fact(table, "Constitutive residual", worst(run, &Step::constitutive_residual), "relative");

  // Forces and heat flows at the end, of the computed part of the slab.
  const Step& last = run.steps.back();
  const std::string when = is_beyond ? "last step, beyond validity" : "last step";
  const bool quarter = is_quarter(run.description);
  const char* const per_metre = quarter ? "" : "/m";
  add_fact(table, "Bottom reaction",
           fmt::format("{:.1f} N{}", last.section().bottom_reaction(), per_metre),
           fmt::format("weight {:.1f} N{}, {}", last.section().weight(), per_metre, when));
  add_fact(table, "Heat through side and bottom",
           fmt::format("{:.1f} kW{}", 1e-3 * last.section().wall_heat_flux(), per_metre),
           fmt::format("{}, {}", quarter ? "of the quarter" : "per metre of face", when));

  // What it took.
  double iterations = 0.0, cut = 0.0;
  for (const Step& step : run.steps) {
    iterations += step.iterations();
    cut += step.failed_attempts();
  }
  const auto steps = double(run.steps.size());
  add_fact(table, "Steps", fmt::format("{:.0f}", steps),
           fmt::format("{:.0f} attempts were cut", cut));
  add_fact(table, "Mechanical iterations", fmt::format("{:.0f}", iterations),
           fmt::format("{:.2f} a step", iterations / steps));
  add_fact(table, "Mesh at the end", fmt::format("{} nodes", last.nodes()),
           fmt::format("{} elements", last.elements()));
}

void add_basis(const v1::Case& input, v1::Judgement& judgement) {
  const v1::Alloy& alloy = input.alloy();
  v1::Table& table = add_facts(judgement, "basis", "what the result rests on");
  add_fact(table, "Mechanics starts", fmt::format("{:.1f} s", input.mechanics().start_s()),
           "from a stress-free shell: what happened before leaves no curl");
  add_fact(table, "Coherency", coherency_text(alloy),
           fmt::format("below it the mush transmits stress; solidus {:.0f}, liquidus {:.0f} °C",
                       alloy.solidus_c(), alloy.liquidus_c()));
  add_fact(table, "Alloy card", fmt::format("{} ({})", alloy.card(), alloy.provenance()),
           alloy.description());
  add_fact(table, "Half width", fmt::format("{:.0f} mm", 1e3 * input.section().half_width_m()));
  add_fact(table, "Element", element_name(input.mesh().element()),
           element_remark(input.mesh().element()));
  add_fact(table, "Algorithm", v1::Mechanics::Algorithm_Name(input.mechanics().algorithm()));
}

}  // namespace dccast::judging
