// Curl of a quarter slab on plans of heat and mechanics of its own: how the qualities were chosen
// (docs/developers/discretisation.md).
//
//   dccast-plan-study CASE QUALITY [KEY=NUMBER ...]
//
// One line: nodes of the heat's mesh, steps, iterations, processor seconds, wall seconds by task,
// what was found, with value and limit; then one for each margin, and one for each monitor, in mm.
// Keys are in m and s, `settled` in mm/s.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "core/casting/slab_run.hpp"
#include "dccast/v1/case.pb.h"
#include "tests/support/load_case.hpp"

namespace {

using namespace dccast;

/// A table of time steps with every length divided.
Curve divided(const Curve& steps, double parts) {
  std::vector<double> lengths = steps.value();
  for (double& length : lengths) length /= parts;
  return {steps.abscissa(), steps.at(), lengths};
}

/// Sets a key of the study. @throws std::out_of_range  an unknown one
void set(casting::Case& c, const std::string& key, double value) {
  mesh::SectionSpec& s = c.section;
  const int number = static_cast<int>(value);
  const std::map<std::string, int*> numbers{{"columns", &s.columns},
                                            {"layers", &s.layers},
                                            {"rows", &s.rows},
                                            {"refinement", &s.refinement},
                                            {"heat_per_column", &s.heat_cells.per_column},
                                            {"heat_per_layer", &s.heat_cells.per_layer}};
  if (const auto found = numbers.find(key); found != numbers.end()) {
    *found->second = number;
    s.side_cell = s.half_width / s.columns;
    s.wide_side_cell = s.half_thickness(s.half_width) / s.layers;
    return;
  }

  const std::map<std::string, double*> lengths{
      {"side_cell", &s.side_cell},       {"wide_side_cell", &s.wide_side_cell},
      {"bottom_cell", &s.bottom_cell},   {"merged_cell", &s.merging.largest_cell},
      {"merge_below", &s.merging.below}, {"end", &c.time.end}};
  if (const auto found = lengths.find(key); found != lengths.end()) {
    *found->second = value;
    return;
  }
  if (key == "settled")
    c.time.settled = 1e-3 * value;
  else if (key == "growth_cell")
    s.growth_cell = value;
  else if (key == "divide_steps")
    c.time.step = divided(c.time.step, value);
  else if (key == "water")
    c.schedule.water_flow_factor = Curve(value);
  else if (key == "speed")
    c.schedule.casting_speed_factor = Curve(value);
  else
    throw std::out_of_range("unknown key " + key);
}

v1::Quality quality_of(const std::string& name) {
  return name == "draft" ? v1::DRAFT : name == "fine" ? v1::FINE : v1::ENGINEERING;
}

}  // namespace

int main(int count, char** values) {
  if (count < 3) return 2;
  casting::Case c = support::load_case(values[1], quality_of(values[2]));
  for (int i = 3; i < count; ++i) {
    const std::string text = values[i];
    const auto equals = text.find('=');
    set(c, text.substr(0, equals), std::atof(text.c_str() + equals + 1));
  }

  casting::SlabRun<3> run(c);
  results::StepReport last;
  int iterations = 0, steps = 0;
  constexpr std::array instants{60.0, 120.0, 250.0, 400.0, 600.0};  // [s]
  std::vector<std::map<int, double>> curls(c.monitors.size());      // [mm] by time
  while (!run.finished()) {
    last = run.advance();
    ++steps;
    iterations += last.iterations;
    for (std::size_t monitor = 0; monitor < curls.size(); ++monitor)
      for (const double time : instants)
        if (last.time >= time - 1e-6 && last.time - last.time_step < time - 1e-6)
          curls[monitor][int(time)] = 1e3 * last.monitor_displacement.at(monitor).back();
  }
  for (std::size_t monitor = 0; monitor < curls.size(); ++monitor)
    curls[monitor][int(last.time)] = 1e3 * last.monitor_displacement.at(monitor).back();

  for (int i = 1; i < count; ++i) std::printf("%s ", values[i]);
  std::printf("| nodes %lld steps %d iterations %d seconds %.2f |",
              static_cast<long long>(last.nodes), steps, iterations, last.solver_seconds);
  const mechanics::CostSplit& cost = run.mechanics_cost();
  std::printf(" heat %.2f tangents %.2f forces %.2f factors %.2f solutions %.2f |",
              run.heat_seconds(), cost.stiffness, cost.forces, cost.preconditioner, cost.solution);
  std::printf(" findings");
  for (const auto& f : run.findings())
    std::printf(" %s at %.0f s: %.4g of %.4g %s", f.code.c_str(), f.time.value_or(0.0),
                f.value.value_or(0.0), f.limit.value_or(0.0), f.unit.c_str());
  std::printf("\n");
  for (const casting::Margin& m : run.margins())
    std::printf("%26s | %s %.5g of %.4g %s at %.0f s\n", m.code.c_str(), m.key.c_str(),
                m.worst.value, m.limit, m.unit.c_str(), m.worst.time);

  for (std::size_t monitor = 0; monitor < curls.size(); ++monitor) {
    std::printf("%26s |", c.monitors[monitor].name.c_str());
    for (const auto& [time, curl] : curls[monitor]) std::printf(" %d s: %.3f", time, curl);
    std::printf("\n");
  }
}
